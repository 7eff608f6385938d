#include "fit/runs/plan.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <filesystem>
#include <fstream>

using namespace brdfit;

// Plans of a run whose digest is right: made so here, where the input is JSON.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string path = fuzz::folder() + "/plan.json";
    std::string text(reinterpret_cast<const char*>(data), size);
    try {
        Json json = parse_json(text, path, "a plan");
        if (json.is_object()) {
            json.erase("sha256");
            json["sha256"] = sha256(nlohmann::json(json).dump());
            text = dumped(json);
        }
    } catch (const InputError&) { // read as it is
    }
    std::ofstream(path, std::ios::binary) << text;
    fuzz::reads(path, [&] {
        const Plan plan = read_plan(fuzz::folder());
        std::size_t tasks = 0;
        for (std::size_t number = 0; number < 3; ++number)
            tasks += tasks_of(plan, {number, 3}).size();
        fuzz::require(tasks == plan.tasks.size(), "tasks that are in no shard, or in two");
        write_plan(plan, fuzz::folder());
        fuzz::require(settings_json(read_plan(fuzz::folder())) == settings_json(plan),
                      "another when written");
    });
    return 0;
}

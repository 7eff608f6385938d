#include "host/files/json.hpp"
#include "host/model/material.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

// Materials beside a table that they may name; what is written of them is read as the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string path = [] {
        write_table(fuzz::example_table(false), fuzz::folder() + "/table.exr");
        return fuzz::folder() + "/material.json";
    }();
    const std::string text(reinterpret_cast<const char*>(data), size);
    Json json;
    if (!fuzz::reads(path, [&] {
            const Material material = parse_material(text, path);
            material.isotropic();
            json = to_json(material);
        }))
        return 0;
    fuzz::require(to_json(parse_material(pretty(json), path)) == json, "another when written");
    return 0;
}

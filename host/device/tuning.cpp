#include "host/device/tuning.hpp"

#include "host/device/kernels.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"

#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <mutex>
#include <spdlog/spdlog.h>

namespace brdfit {

namespace {

constexpr std::size_t most_bytes = 1 << 20; // of a tuning file

bool power_of_2(int x) {
    return x > 0 && (x & (x - 1)) == 0;
}

// The entries of the file; empty where there is none. Throws InputError for anything else.
Json read_entries(const std::string& path) {
    std::error_code error;
    const bool there = std::filesystem::exists(path, error);
    if (error)
        throw InputError(fmt::format("{}: cannot open: {}", path, error.message()));
    if (!there)
        return Json::array();
    const std::string expected = "what brdfit tune writes, an object with a list 'tuning'";
    const Json json = read_json(path, expected, most_bytes);
    const Place top{path, ""};
    check_object(json, top, expected);
    const Json& entries = required(json, top, "tuning", "a list");
    if (!entries.is_array())
        top.member("tuning").fail(entries, "a list");
    return entries;
}

// Says what is wrong with the file, once however many devices ask.
void warn(const std::string& problem) {
    static std::mutex mutex;
    static std::string said;
    const std::lock_guard<std::mutex> lock(mutex);
    if (problem != said)
        spdlog::warn("{}; ignored", problem);
    said = problem;
}

bool is_of(const Json& entry, const Device& device) {
    return entry.is_object() && entry.value("device", Json()) == device.name &&
           entry.value("platform", Json()) == device.platform;
}

} // namespace

bool is_possible(const Form& form, const Device& device) {
    return power_of_2(form.vector_width) && form.vector_width <= 16 &&
           power_of_2(form.local_size) && form.local_size <= 1024 &&
           static_cast<std::size_t>(form.local_size) <= device.max_group &&
           static_cast<std::size_t>(form.local_size) * sizeof(float) <= device.local_memory &&
           form.block >= 1 && form.block <= 1 << 20 &&
           form.block % (form.vector_width * form.local_size) == 0 && form.candidates >= 1 &&
           form.candidates <= 16;
}

Json to_json(const Form& form) {
    return {{"vector_width", form.vector_width},
            {"local_size", form.local_size},
            {"block", form.block},
            {"candidates", form.candidates}};
}

std::string tuning_path() {
    if (const char* path = std::getenv("BRDFIT_TUNING"))
        return path;
    if (const char* folder = std::getenv("XDG_CONFIG_HOME"); folder != nullptr && *folder != 0)
        return fmt::format("{}/brdfit/tuning.json", folder);
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0)
        return fmt::format("{}/.config/brdfit/tuning.json", home);
    return "";
}

std::optional<TunedForm> tuned_form(const Device& device) {
    const std::string path = tuning_path();
    if (path.empty())
        return std::nullopt;
    try {
        const Json entries = read_entries(path);
        for (std::size_t i = 0; i < entries.size(); ++i) {
            const Json& entry = entries[i];
            const Place at = Place{path, "tuning"}.element(i);
            if (!is_of(entry, device) ||
                required(entry, at, "driver", "a driver's version") != device.driver ||
                required(entry, at, "kernels", "the kernels' hash") != kernel_hash())
                continue;
            const auto number = [&](const char* key) {
                return static_cast<int>(
                    parse_number(required(entry, at, key, "a number"), at.member(key), 1, 1 << 20));
            };
            const Form form{number("vector_width"), number("local_size"), number("block"),
                            number("candidates")};
            if (!is_possible(form, device))
                at.fail(fmt::format("the form of {} is none it can run", device.name));
            const Json reason = entry.value("reason", Json());
            return TunedForm{form, reason.is_string() ? reason.get<std::string>()
                                                      : "brdfit tune found it"};
        }
    } catch (const InputError& error) {
        warn(error.what());
    }
    return std::nullopt;
}

void store_tuned_form(const Device& device, const Form& form, const std::string& reason) {
    const std::string path = tuning_path();
    if (path.empty())
        throw InputError("no place to keep the tuning: none of BRDFIT_TUNING, XDG_CONFIG_HOME and "
                         "HOME is set");
    Json entries = Json::array();
    for (const auto& entry : read_entries(path))
        if (!is_of(entry, device))
            entries.push_back(entry);
    Json entry = {{"device", device.name},
                  {"platform", device.platform},
                  {"driver", device.driver},
                  {"kernels", kernel_hash()},
                  {"reason", reason}};
    entry.update(to_json(form));
    entries.push_back(entry);
    const std::string folder = std::filesystem::path(path).parent_path();
    if (!folder.empty())
        make_output_folder(folder);
    OutputFile file(path);
    file.write(Json{{"tuning", entries}}.dump(2) + "\n");
    file.commit(false, Replaced::Unsaid);
}

} // namespace brdfit

#include "host/cli/command.hpp"
#include "host/device/binaries.hpp"
#include "host/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace brdfit::cli {

namespace {

int cache(bool clear, bool json) {
    const std::string folder = binary_folder();
    const KeptBinaries kept = clear ? clear_binaries() : count_binaries();
    if (json) {
        fmt::print("{}\n", nlohmann::ordered_json{{"folder", folder},
                                                  {clear ? "removed" : "programs", kept.files},
                                                  {"bytes", kept.bytes},
                                                  {"most_bytes", most_binary_bytes}}
                               .dump(2));
        return 0;
    }
    if (folder.empty()) {
        fmt::print("no kernels are kept: no folder is named\n");
        return 0;
    }
    const double mib = static_cast<double>(kept.bytes) / (1 << 20);
    if (clear)
        fmt::print("{}: {} built programs removed, {:.1f} MiB\n", folder, kept.files, mib);
    else
        fmt::print("{}: {} built programs, {:.1f} of at most {} MiB\n", folder, kept.files, mib,
                   most_binary_bytes >> 20);
    return 0;
}

} // namespace

void add_cache(CLI::App& app, const Globals&, Action& action) {
    CLI::App* command = app.add_subcommand("cache", "Say which built kernels are kept, and where");
    auto clear = std::make_shared<bool>(false);
    auto json = std::make_shared<bool>(false);
    command->add_flag("--clear", *clear, "remove them");
    command->add_flag("--json", *json, "as JSON");
    command->footer("In the folder that BRDFIT_CACHE names, otherwise in brdfit in $XDG_CACHE_HOME "
                    "or ~/.cache; BRDFIT_CACHE=\nkeeps none. PoCL, which keeps its own, is left "
                    "alone (see brdfit devices --help).\n"
                    "Example:\n  brdfit cache --clear");
    command->callback(
        [clear, json, &action] { action = [clear, json] { return cache(*clear, *json); }; });
}

} // namespace brdfit::cli

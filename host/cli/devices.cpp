#include "host/cli/command.hpp"
#include "host/device/device.hpp"
#include "host/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace brdfit::cli {

namespace {

int devices(bool json, const Globals& globals) {
    const std::vector<Device> all = list_devices();
    if (all.empty())
        open_device(); // says which package to install
    const std::size_t chosen = default_device(all);
    const int only = globals.device.empty() ? -1 : open_device(globals.device).index;
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Device& d : all) {
        if (only >= 0 && d.index != only)
            continue;
        list.push_back({{"index", d.index},
                        {"name", d.name},
                        {"platform", d.platform},
                        {"vendor", d.vendor},
                        {"version", d.version},
                        {"driver", d.driver},
                        {"type", d.cpu ? "cpu" : "gpu"},
                        {"compute_units", d.compute_units},
                        {"global_memory", d.global_memory},
                        {"local_memory", d.local_memory},
                        {"max_allocation", d.max_allocation},
                        {"max_group", d.max_group},
                        {"default", static_cast<std::size_t>(d.index) == chosen}});
        if (!json)
            fmt::print(
                "{}{} {} ({})\n    {}, driver {}, {} compute units, {:.1f} GiB, {} KiB local\n",
                static_cast<std::size_t>(d.index) == chosen ? "*" : " ", d.index, d.name,
                d.platform, d.version, d.driver, d.compute_units,
                static_cast<double>(d.global_memory) / (1 << 30), d.local_memory >> 10);
    }
    if (json)
        fmt::print("{}\n", list.dump(2));
    return 0;
}

} // namespace

void add_devices(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "devices", "List the OpenCL devices, the default marked *; with --device that one");
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "as JSON");
    command->footer("PoCL, the driver for CPUs, keeps the kernels it has built in POCL_CACHE_DIR "
                    "(~/.cache/pocl/kcache where\nthat is not set), which it must be able to write "
                    "to; where programs crash in it, remove that folder.\n"
                    "Example:\n  brdfit devices --json");
    command->callback([json, &globals, &action] {
        action = [json, &globals] { return devices(*json, globals); };
    });
}

} // namespace brdfit::cli

#include "host/cli/command.hpp"
#include "host/device/binaries.hpp"
#include "host/device/cache.hpp"
#include "host/device/device.hpp"
#include "host/device/tuning.hpp"
#include "host/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace brdfit::cli {

namespace {

// What `devices -v` says of a device that was opened.
std::string choices_of(const Device& d) {
    const Form& f = d.form;
    return fmt::format(
        "    form: {}, {} work-item{} a group, blocks of {}, {} candidates at once; {}\n"
        "    built kernels: kept by {}\n"
        "    fewer threads: {}\n",
        f.vector_width == 1 ? "scalars" : fmt::format("vectors of {}", f.vector_width),
        f.local_size, f.local_size == 1 ? "" : "s", f.block, f.candidates,
        d.wrong.empty() ? d.form_reason : "WRONG VALUES: " + d.wrong,
        keeps_binaries(d)     ? "brdfit, in " + binary_folder()
        : is_pocl(d.platform) ? "the driver, in " + pocl_cache().folder
                              : std::string("nobody: no folder is named"),
        has_sub_devices(d) ? "BRDFIT_UNITS=N, by sub-devices" : "the driver has no sub-devices");
}

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
        const Device used = globals.verbose ? open_device(std::to_string(d.index)) : d;
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
        if (globals.verbose)
            list.back().update({{"form", to_json(used.form)},
                                {"form_reason", used.form_reason},
                                {"wrong", used.wrong},
                                {"keeps_binaries", keeps_binaries(d)},
                                {"sub_devices", has_sub_devices(d)}});
        if (!json) {
            fmt::print(
                "{}{} {} ({})\n    {}, driver {}, {} compute units, {:.1f} GiB, {} KiB local\n",
                static_cast<std::size_t>(d.index) == chosen ? "*" : " ", d.index, d.name,
                d.platform, d.version, d.driver, d.compute_units,
                static_cast<double>(d.global_memory) / (1 << 30), d.local_memory >> 10);
            if (globals.verbose)
                fmt::print("{}", choices_of(used));
        }
    }
    if (json)
        fmt::print("{}\n", list.dump(2));
    return 0;
}

} // namespace

void add_devices(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("devices", "List the OpenCL devices, the default marked *; with "
                                      "--device that one, with -v how they are used");
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "as JSON");
    command->footer("PoCL, the driver for CPUs, keeps the kernels it has built in POCL_CACHE_DIR "
                    "(~/.cache/pocl/kcache where\nthat is not set), which it must be able to write "
                    "to; where programs crash in it, remove that folder.\n"
                    "BRDFIT_UNITS=N uses N compute units of a device only.\n"
                    "Example:\n  brdfit devices --json");
    command->callback([json, &globals, &action] {
        action = [json, &globals] { return devices(*json, globals); };
    });
}

} // namespace brdfit::cli

#include "bench/again.hpp"
#include "bench/portability.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/device/kernels.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::vector<std::string> models;
    std::string json;
    std::size_t samples = 0; // of the speeds; 0: a whole file
    bool child = false;
};

using bench::Portability;

// One device, in a process that may crash with its driver.
Portability measured_apart(const Device& device, const Options& options) {
    std::vector<std::string> arguments = {
        "--device",  std::to_string(device.index),   "bench", "portability", "--child",
        "--samples", std::to_string(options.samples)};
    for (const std::string& model : options.models)
        arguments.insert(arguments.end(), {"-m", model});
    std::string failure;
    try {
        return bench::portability_from_message(
            nlohmann::ordered_json::parse(bench::run_again(arguments, {})));
    } catch (const InputError&) {
        failure = "its process failed";
    } catch (const nlohmann::json::exception& error) {
        failure = fmt::format("unexpected output: {}", error.what());
    }
    Portability none;
    none.device = device.name;
    none.platform = device.platform;
    none.driver = device.driver;
    none.threads = static_cast<int>(device.compute_units);
    none.form = "-";
    none.failure = failure;
    return none;
}

nlohmann::ordered_json to_json(const std::vector<Portability>& devices) {
    nlohmann::ordered_json json = {{"version", version},
                                   {"kernels", kernel_hash()},
                                   {"machine", bench::processor_name()},
                                   {"devices", nlohmann::ordered_json::array()},
                                   {"results", nlohmann::ordered_json::array()}};
    for (const Portability& device : devices) {
        json["devices"].push_back(to_json(device));
        for (const bench::Result& result : device.measured.results)
            json["results"].push_back(to_json(
                result, device.measured.peaks.empty() ? nullptr : &device.measured.peaks.front()));
    }
    return json;
}

int bench_portability(const Options& options, const Globals& globals) {
    const std::vector<bench::Problem> problems = bench::problems(options.models);
    if (options.child) {
        const Portability found =
            bench::measure_portability(open_device(globals.device), problems, options.samples);
        fmt::print("{}\n", portability_message(found).dump());
        return 0;
    }
    std::vector<Device> used;
    for (const Device& device : list_devices())
        if (globals.device.empty() || globals.device == "all")
            used.push_back(device);
    if (used.empty())
        used.push_back(open_device(globals.device));
    std::optional<OutputFile> json; // opened first: a path that cannot be written costs no time
    if (!options.json.empty())
        json.emplace(options.json);
    std::vector<Portability> found;
    {
        Progress progress(used.size(), globals.quiet);
        for (const Device& device : used) {
            progress.show(found.size(), device.name);
            found.push_back(measured_apart(device, options));
        }
    }
    bench::compare_albedos(found);
    fmt::print("machine: {}\n\n{}", bench::processor_name(), bench::portability_table(found));
    if (json) {
        json->write(to_json(found).dump(2) + "\n");
        json->commit();
    }
    const bool wrong = std::any_of(found.begin(), found.end(), [](const Portability& p) {
        return !p.failure.empty() || std::any_of(p.agreements.begin(), p.agreements.end(),
                                                 [](const auto& a) { return a.wrong(); });
    });
    return wrong ? 1 : 0;
}

} // namespace

void add_bench_portability(CLI::App& bench, const Globals& globals, Action& action) {
    CLI::App* command = bench.add_subcommand(
        "portability", "Hold what every device computes against float64, and compare their speeds");
    auto options = std::make_shared<Options>();
    command->add_option("-m,--model", options->models, "models, with commas; default: all")
        ->delimiter(',')
        ->allow_extra_args(false);
    command->add_option("--json", options->json,
                        "file to write all rows to, as JSON; bench compare reads two of them");
    command->add_option("--samples", options->samples)->group("");
    command->add_flag("--child", options->child)->group("");
    command->footer("On every device, or the one that --device names.\n"
                    "Exit status: 0 all agree, 1 a device is wrong or fails.\n"
                    "Example:\n  brdfit bench portability --json here.json");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return bench_portability(*options, globals); };
    });
}

} // namespace brdfit::cli

#include "bench/sampling.hpp"
#include "bench/work.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/device/kernels.hpp"
#include "host/files/file.hpp"
#include "host/model/structure.hpp"
#include "host/version.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <optional>

namespace brdfit::cli {

namespace {

struct Options {
    std::vector<std::string> materials;
    double theta = 45;
    std::string json;
};

int bench_sampling(const Options& options, const Globals& globals) {
    std::vector<bench::NamedMaterial> materials;
    for (const std::string& path : options.materials)
        materials.push_back(
            {std::filesystem::path(path).stem().string(), read_material_file(path)});
    if (materials.empty())
        materials = bench::catalogue_materials();
    const Device device = open_device(globals.device);
    std::optional<OutputFile> json; // opened first: a path that cannot be written costs no time
    if (!options.json.empty())
        json.emplace(options.json);

    std::size_t width = 0;
    for (const bench::NamedMaterial& named : materials)
        width = std::max(width, named.name.size());
    fmt::print(
        "device: {} ({}, driver {}), {} compute units\n"
        "albedo for a viewer at {} degrees and the variance of one sample's estimate of it; "
        "cosine: of\ndirections drawn from the cosine's density instead; rejected: below the "
        "horizon; millions of samples/s\n\n"
        "{:<{}} {:>8} {:>10} {:>10} {:>9} {:>7} {:>7}\n",
        device.name, device.platform, device.driver, device.compute_units, options.theta, "", width,
        "albedo", "variance", "cosine", "rejected", "sobol", "philox");
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const bench::NamedMaterial& named : materials) {
        const bench::SamplingResult r =
            bench::measure_sampling(device, named, options.theta * degree);
        fmt::print("{:<{}} {:>8.4f} {:>10.3g} {:>10.3g} {:>8.2f}% {:>7.1f} {:>7.1f}\n", r.name,
                   width, r.albedo, r.variance, r.cosine_variance, 100 * r.rejected, r.sobol / 1e6,
                   r.philox / 1e6);
        rows.push_back(to_json(r));
    }
    if (json) {
        const nlohmann::ordered_json file = {{"device", device.name},
                                             {"platform", device.platform},
                                             {"driver", device.driver},
                                             {"compute_units", device.compute_units},
                                             {"version", version},
                                             {"kernels", kernel_hash()},
                                             {"machine", bench::processor_name()},
                                             {"theta_o", options.theta * degree},
                                             {"results", rows}};
        json->write(file.dump(2) + "\n");
        json->commit();
    }
    return 0;
}

} // namespace

void add_bench_sampling(CLI::App& bench, const Globals& globals, Action& action) {
    CLI::App* command = bench.add_subcommand(
        "sampling", "Measure the variance and speed of drawing directions, model by model");
    auto options = std::make_shared<Options>();
    command->add_option(
        "MATERIAL", options->materials,
        "material files, as fitted to one measurement; default: every model, with one "
        "roughness");
    command->add_option("--theta", options->theta, "viewer's angle from the normal in degrees")
        ->check(CLI::Range(0.0, 89.99))
        ->capture_default_str();
    command->add_option("--json", options->json, "file to write the results to, as JSON");
    command->footer("Example:\n  brdfit bench sampling fits/*.json --theta 60");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return bench_sampling(*options, globals); };
    });
}

} // namespace brdfit::cli

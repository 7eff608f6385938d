#include "fit/compare.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"
#include "host/image/map.hpp"
#include "host/version.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string a, b, svg;
    double max_theta = 80;
    std::size_t worst = 5;
    Isotropy isotropy;
    bool json = false;
};

void print_json(const Comparison& comparison, const ComparedValues& values,
                const Options& options) {
    Json json{{"a", options.a}, {"b", options.b}};
    json.update(comparison_json(comparison, values, options.max_theta));
    fmt::print("{}\n", json.dump(2));
}

std::string percent(double share) {
    return std::isfinite(share) ? fmt::format("{:.3g} %", 100 * share) : "-";
}

void print_bands(const char* angle, const std::vector<Band>& bands) {
    fmt::print("{:9} {:>9} {:>11} {:>9} {:>9} {:>9} {:>9}\n", angle, "samples", "ngan", "share",
               "bias", "median", "95th");
    for (const Band& band : bands) {
        const Difference& of = band.difference;
        fmt::print("{:9} {:>9} {:>11.4g} {:>9} {:>9} {:>9} {:>9}\n",
                   fmt::format("{:g}-{:g}", band.from, band.to), of.samples, of.errors[0],
                   percent(of.share), percent(of.bias), percent(of.median), percent(of.high));
    }
}

/// A sample in the channel that differs most.
void print_sample(const WorstSample& worst, const ComparedValues& values) {
    const std::size_t count = values.a.count();
    const auto a = [&](std::size_t c) { return values.a.channel(c)[worst.sample]; };
    const auto b = [&](std::size_t c) { return values.b[c * count + worst.sample]; };
    std::size_t most = 0;
    for (std::size_t c = 0; c < values.a.channels.size(); ++c)
        if (std::abs(b(c) - a(c)) > std::abs(b(most) - a(most)))
            most = c;
    fmt::print("{:>7.2f} {:>7.2f} {:>7.2f} {:>7.2f} {:>7.2f} {:>7.2f}  {} {:>10.4g} {:>10.4g} "
               "{:>9}\n",
               worst.theta_i, worst.phi_i, worst.theta_o, worst.phi_o, worst.theta_h, worst.theta_d,
               values.a.channels[most], a(most), b(most), percent(worst.relative));
}

void print_text(const Comparison& comparison, const ComparedValues& values,
                const Options& options) {
    const Difference& all = comparison.all;
    fmt::print("A: {}\nB: {}\nat {} of {}, up to {:g} degrees; channels {}\n", options.a, options.b,
               all.samples, values.at, options.max_theta, fmt::join(values.a.channels, ", "));
    for (int m = 0; m < metric_count; ++m)
        fmt::print("{}{} {:.4g}", m == 0 ? "" : "  ", name_of(static_cast<Metric>(m)),
                   all.errors[static_cast<std::size_t>(m)]);
    fmt::print("\nbias {}; relative error: median {}, 95th percentile {}, largest {}",
               percent(all.bias), percent(all.median), percent(all.high), percent(all.largest));
    if (all.zeros > 0)
        fmt::print(", without {} where A is 0", all.zeros);
    fmt::print("\n\n");
    print_bands("theta_i", comparison.theta_i);
    print_bands("theta_h", comparison.theta_h);
    print_bands("theta_d", comparison.theta_d);
    fmt::print("\n{:>7} {:>7} {:>7} {:>7} {:>7} {:>7}  channel, A, B, relative\n", "theta_i",
               "phi_i", "theta_o", "phi_o", "theta_h", "theta_d");
    for (const WorstSample& worst : comparison.worst)
        print_sample(worst, values);
    if (std::isfinite(all.largest)) {
        fmt::print("the largest relative error:\n");
        print_sample(comparison.largest_relative, values);
    }
}

void write_svg(const ComparedValues& values, const Options& options) {
    const auto name = [](const std::string& path) {
        return std::filesystem::path(path).filename().string();
    };
    const DifferenceMap difference = difference_map(values, options.max_theta);
    Map map;
    map.title = fmt::format("{} against {}", name(options.b), name(options.a));
    map.x_title = "theta_h (degrees)";
    map.y_title = "theta_d (degrees)";
    map.scale_title = "(B - A) / A";
    map.comment = fmt::format("brdfit {}: the mean of B - A over that of A, weighted by solid "
                              "angle and cosine, at {}",
                              version, values.at);
    map.x = difference.theta_h;
    map.y = difference.theta_d;
    map.x_ticks = {0, 1, 5, 10, 20, 30, 45, 60, 90};
    map.y_ticks = {0, 15, 30, 45, 60, 75, 90};
    map.values = difference.bias;
    write_map(map, options.svg);
}

int compare(const Options& options, const Globals& globals) {
    if (!options.svg.empty() && std::filesystem::path(options.svg).extension() != ".svg")
        throw UsageError(fmt::format("--svg {}: unknown ending; expected .svg", options.svg));
    Progress progress(3, globals.quiet);
    progress.show(0, options.a);
    // What is said of scattered data goes for the measured ones of the two.
    const auto read = [&](const std::string& path) {
        return read_brdf(path, is_measurement(path) ? options.isotropy.choice() : std::nullopt);
    };
    const Brdf a = read(options.a);
    progress.show(0, options.b);
    const Brdf b = read(options.b);
    if (options.isotropy.choice() && a.measured() == nullptr && b.measured() == nullptr)
        throw UsageError("--isotropic and --anisotropic: both are materials; expected them with "
                         "measured files");
    const Device device = open_device(globals.device);
    const ComparedValues values =
        values_to_compare(device, a, b, options.a, options.b, progress.step(1, "evaluating"));
    progress.show(2, "comparing");
    const Comparison comparison = compare(values, options.max_theta, options.worst);
    if (!options.svg.empty())
        write_svg(values, options);
    progress.clear();
    for (const Brdf* brdf : {&a, &b})
        if (brdf->measured() != nullptr)
            spdlog::debug("{}: evaluated {}", brdf == &a ? options.a : options.b,
                          brdf->measured()->method());
    if (options.json)
        print_json(comparison, values, options);
    else
        print_text(comparison, values, options);
    return 0;
}

} // namespace

void add_compare(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "compare", "Compare two materials or measurements: errors, where they are, the worst");
    auto options = std::make_shared<Options>();
    command
        ->add_option("A", options->a,
                     "material (.json) or measured reflectance, which B is compared with")
        ->required();
    command->add_option("B", options->b, "material (.json) or measured reflectance")->required();
    command
        ->add_option("--max-theta", options->max_theta,
                     "drop samples beyond this angle from the normal, degrees")
        ->check(within(1, 90))
        ->capture_default_str();
    command->add_option("--worst", options->worst, "how many of the worst samples are shown")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    command->add_option("--svg", options->svg,
                        "also draw a map of (B - A) / A over theta_h and theta_d");
    command->add_flag("--json", options->json, "print the results as JSON");
    options->isotropy.add_to(*command);
    command->footer("Examples:\n  brdfit compare nickel.binary nickel.kurt.1.json\n"
                    "  brdfit compare paint.bsdf paint.json --svg map.svg --json");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return compare(*options, globals); };
    });
}

} // namespace brdfit::cli

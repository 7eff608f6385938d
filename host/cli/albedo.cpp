#include "host/albedo/file.hpp"
#include "host/albedo/material.hpp"
#include "host/albedo/measured.hpp"
#include "host/cli/command.hpp"
#include "host/cli/isotropy.hpp"
#include "host/error.hpp"
#include "host/files/json.hpp"
#include "host/image/plot.hpp"
#include "host/measured/read.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

constexpr std::size_t anisotropic_azimuths = 36;
constexpr std::size_t most_directions_of_albedo = 1 << 20;

struct Options {
    std::vector<std::string> inputs;
    std::string out, title;
    std::size_t thetas = 0, phis = 0; // 0: not given
    double tolerance = 1e-4, top = 0;
    Isotropy isotropy;
    bool json = false;
};

/// Material files are JSON objects; nothing measured begins like one.
bool is_material(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    char c = 0;
    while (file.get(c) && (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\xEF' ||
                           c == '\xBB' || c == '\xBF'))
        ;
    return file && c == '{';
}

Albedo albedo_of(const std::string& path, const Options& options, const Globals& globals) {
    AlbedoGrid grid;
    if (options.thetas > 0)
        grid.thetas = options.thetas;
    if (is_material(path)) {
        if (options.isotropy.choice())
            throw UsageError(fmt::format("--isotropic and --anisotropic: {} is a material; "
                                         "expected them with measured files",
                                         path));
        const Material material = read_material(path);
        grid.phis =
            options.phis > 0 ? options.phis : (material.isotropic() ? 1 : anisotropic_azimuths);
        if (grid.thetas * grid.phis > most_directions_of_albedo)
            throw UsageError(fmt::format("--theta {} --phi {}: expected at most {} directions",
                                         grid.thetas, grid.phis, most_directions_of_albedo));
        return albedo(open_device(globals.device), material, grid, options.tolerance);
    }
    const Samples samples = read_samples(path, options.isotropy.choice());
    if (!on_grid(samples) && (options.thetas > 0 || options.phis > 0))
        throw UsageError(fmt::format("--theta and --phi: {} has directions of its own", path));
    grid.phis = options.phis > 0 ? options.phis : 1;
    return measured_albedo(samples, grid, options.tolerance);
}

/// Ranges of theta where a channel's albedo is above 1 by more than its error.
std::string above_one(const Albedo& albedo, std::size_t ch) {
    std::set<double> above;
    double largest = 0;
    for (std::size_t k = 0; k < albedo.count(); ++k) {
        largest = std::max(largest, albedo.values[ch][k]);
        if (albedo.values[ch][k] - albedo.errors[ch][k] > 1)
            above.insert(albedo.theta[k]);
    }
    if (above.empty())
        return "";
    return fmt::format("R > 1 at {} of the angles, from {:.4g} to {:.4g} degrees; largest {:.4g}",
                       above.size(), *above.begin() / degree, *above.rbegin() / degree, largest);
}

nlohmann::ordered_json number(double x) { // JSON has no infinity
    return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json("inf");
}

nlohmann::ordered_json to_json(const std::string& path, const Albedo& albedo) {
    nlohmann::ordered_json channels = nlohmann::ordered_json::array();
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch) {
        const std::string above = above_one(albedo, ch);
        channels.push_back({{"channel", albedo.channels[ch]},
                            {"hemispherical", number(albedo.average[ch])},
                            {"error", number(albedo.average_error[ch])},
                            {"above_one", !above.empty()},
                            {"largest", number(*std::max_element(albedo.values[ch].begin(),
                                                                 albedo.values[ch].end()))}});
    }
    return {{"source", path},
            {"channels", channels},
            {"measured", albedo.average_measured},
            {"directions", albedo.count()},
            {"notes", albedo.notes}};
}

void print(const std::string& path, const Albedo& albedo) {
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch) {
        fmt::print("{} {}: hemispherical albedo {:.6g} +- {:.2g}", path, albedo.channels[ch],
                   albedo.average[ch], albedo.average_error[ch]);
        if (!albedo.measured.empty())
            fmt::print(", {:.1f}% of the hemispheres measured", 100 * albedo.average_measured);
        fmt::print("\n");
        if (const std::string above = above_one(albedo, ch); !above.empty())
            fmt::print("{} {}: {}\n", path, albedo.channels[ch], above);
    }
}

std::string stem_of(const std::string& path) {
    return std::filesystem::path(path).stem().string();
}

/// A plot of all inputs: the mean over channels, along the first azimuth.
void plot(const Options& options, const std::vector<Albedo>& albedos) {
    std::vector<Curve> curves;
    double largest = 0;
    for (std::size_t i = 0; i < albedos.size(); ++i) {
        const Albedo& albedo = albedos[i];
        Curve curve;
        curve.name = stem_of(options.inputs[i]);
        for (std::size_t k = 0; k < (albedo.columns ? albedo.columns : albedo.count()); ++k) {
            double mean = 0;
            for (const auto& values : albedo.values)
                mean += values[k] / static_cast<double>(albedo.values.size());
            curve.x.push_back(albedo.theta[k] / degree);
            curve.y.push_back(mean);
            if (std::isfinite(mean))
                largest = std::max(largest, mean);
        }
        curves.push_back(std::move(curve));
    }
    const double top = options.top > 0 ? options.top : std::clamp(1.05 * largest, 0.1, 3.0);
    write_plot(curves, options.title.empty() ? "directional albedo R" : options.title, top,
               options.out,
               fmt::format("directional albedo, mean over channels, tolerance {}, by brdfit {}",
                           options.tolerance, version));
}

int run_albedo(const Options& options, const Globals& globals) {
    require_tolerance(options.tolerance);
    const std::string ending = std::filesystem::path(options.out).extension().string();
    if (ending != ".csv" && ending != ".exr" && ending != ".svg")
        throw UsageError(
            fmt::format("{}: unknown ending; expected .csv, .exr or .svg", options.out));
    if (options.inputs.size() > 1 && ending != ".svg")
        throw UsageError(fmt::format("{}: holds one input; only .svg shows several", options.out));
    if (ending != ".svg" && (options.top > 0 || !options.title.empty()))
        throw UsageError("--top and --title: for .svg only");
    std::vector<Albedo> albedos;
    for (const std::string& path : options.inputs) {
        albedos.push_back(albedo_of(path, options, globals));
        for (const std::string& note : albedos.back().notes)
            if (note.find("did not reach") != std::string::npos)
                spdlog::warn("{}: {}", path, note);
    }
    if (ending == ".svg")
        plot(options, albedos);
    else
        write_albedo(albedos[0], options.out,
                     std::filesystem::path(options.inputs[0]).filename().string());
    if (options.json) {
        nlohmann::ordered_json rows = nlohmann::ordered_json::array();
        for (std::size_t i = 0; i < albedos.size(); ++i)
            rows.push_back(to_json(options.inputs[i], albedos[i]));
        fmt::print("{}\n", dumped(rows, 2));
    } else {
        for (std::size_t i = 0; i < albedos.size(); ++i)
            print(options.inputs[i], albedos[i]);
    }
    return 0;
}

} // namespace

void add_albedo(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "albedo", "Directional and hemispherical albedo of a material or of measurements");
    auto options = std::make_shared<Options>();
    command
        ->add_option("MATERIAL|FILE", options->inputs,
                     "material file (.json) or measured reflectance in any known format; several "
                     "for a plot")
        ->required();
    command
        ->add_option(
            "--theta", options->thetas,
            "how many angles from the normal, 0 to 90 degrees, both included (default: 91)")
        ->check(CLI::Range(std::size_t{2}, most_directions_of_albedo));
    command
        ->add_option("--phi", options->phis,
                     "how many azimuths of the full turn (default: 1, anisotropic materials 36)")
        ->check(CLI::Range(std::size_t{1}, most_directions_of_albedo));
    command
        ->add_option("--tolerance", options->tolerance,
                     "absolute error to refine to; of albedos above 1 where that costs too much, "
                     "relative")
        ->capture_default_str();
    command
        ->add_option("-o,--output", options->out,
                     ".csv or .exr: theta, phi in radians, a column or plane a channel, "
                     "<channel>_error; .svg: a plot")
        ->required();
    command->add_option("--title", options->title, "of the plot");
    command->add_option("--top", options->top, "largest albedo the plot shows")
        ->check(CLI::PositiveNumber);
    command->add_flag("--json", options->json, "print the hemispherical albedo as JSON");
    options->isotropy.add_to(*command);
    command->footer("Examples:\n  brdfit albedo paint.json -o albedo.csv\n"
                    "  brdfit albedo nickel.binary nickel.kurt.1.json -o albedo.svg");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return run_albedo(*options, globals); };
    });
}

} // namespace brdfit::cli

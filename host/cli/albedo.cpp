#include "host/albedo/file.hpp"
#include "host/albedo/material.hpp"
#include "host/albedo/measured.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/files/json.hpp"
#include "host/image/plot.hpp"
#include "host/measured/read.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
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
    bool json = false, tolerance_given = false;
};

/// An input, read: one of the two.
struct Input {
    std::optional<Material> material;
    std::optional<Samples> samples;
};

/// Reads an input. Throws UsageError for options that do not apply to it.
Input read_input(const std::string& path, const Options& options, const Globals& globals) {
    Input input;
    if (!is_measurement(path)) {
        if (options.isotropy.choice())
            throw UsageError(fmt::format("--isotropic and --anisotropic: {} is a material; "
                                         "expected them with measured files",
                                         path));
        input.material = read_material(path);
        return input;
    }
    input.samples = read_samples(path, options.isotropy.choice());
    if (!on_grid(*input.samples) && (options.thetas > 0 || options.phis > 0))
        throw UsageError(fmt::format("--theta and --phi: {} has directions of its own", path));
    if (!on_grid(*input.samples) && options.tolerance_given)
        throw UsageError(fmt::format("--tolerance: {} has directions of its own, whose number "
                                     "says how near the sum is",
                                     path));
    if (!globals.device.empty() && options.inputs.size() == 1)
        throw UsageError(
            fmt::format("--device: {} is a measurement; expected it with materials", path));
    return input;
}

AlbedoGrid grid_of(const Input& input, const Options& options) {
    AlbedoGrid grid;
    if (options.thetas > 0)
        grid.thetas = options.thetas;
    grid.phis = options.phis > 0                                 ? options.phis
                : input.material && !input.material->isotropic() ? anisotropic_azimuths
                                                                 : 1;
    if (grid.thetas * grid.phis > most_directions_of_albedo)
        throw UsageError(fmt::format("--theta {} --phi {}: expected at most {} directions",
                                     grid.thetas, grid.phis, most_directions_of_albedo));
    return grid;
}

Albedo albedo_of(const Input& input, const Options& options, const Globals& globals,
                 const ProgressFunction& progress) {
    const AlbedoGrid grid = grid_of(input, options);
    return input.material ? albedo(open_device(globals.device), *input.material, grid,
                                   options.tolerance, progress)
                          : measured_albedo(*input.samples, grid, options.tolerance, progress);
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

/// A plot of all inputs along the first azimuth: the channels of one input, or the mean over
/// channels of several.
void plot(const Options& options, const std::vector<Albedo>& albedos) {
    constexpr std::size_t most_channels = 4;
    const bool each = albedos.size() == 1 && albedos[0].channels.size() <= most_channels;
    const std::vector<std::string> names = distinct_names(options.inputs);
    std::vector<Curve> curves;
    bool mean = false;
    for (std::size_t i = 0; i < albedos.size(); ++i) {
        const Albedo& albedo = albedos[i];
        const std::size_t channels = albedo.channels.size();
        mean |= !each && channels > 1;
        for (std::size_t first = 0; first < (each ? channels : 1); ++first) {
            Curve curve;
            curve.name = names[i];
            if (each && channels > 1)
                curve.name += ", channel " + albedo.channels[first];
            for (std::size_t k = 0; k < (albedo.columns ? albedo.columns : albedo.count()); ++k) {
                double sum = 0;
                for (std::size_t ch = first; ch < (each ? first + 1 : channels); ++ch)
                    sum += albedo.values[ch][k];
                curve.x.push_back(albedo.theta[k] / degree);
                curve.y.push_back(sum / static_cast<double>(each ? 1 : channels));
            }
            curves.push_back(std::move(curve));
        }
    }
    PlotOptions of_plot;
    of_plot.title = options.title.empty() ? "Directional albedo" : options.title;
    if (mean)
        of_plot.title += " (mean over channels)";
    of_plot.y_title = "directional albedo (reflected / received)";
    of_plot.comment =
        fmt::format("directional albedo, {}, tolerance {}, by brdfit {}",
                    mean ? "mean over channels" : "a curve a channel", options.tolerance, version);
    of_plot.top = options.top;
    write_plot(curves, of_plot, options.out);
}

int run_albedo(const Options& options, const Globals& globals) {
    require_tolerance(options.tolerance);
    const std::string ending = std::filesystem::path(options.out).extension().string();
    const bool plots = ending == ".svg" || ending == ".png";
    if (!options.out.empty() && ending != ".csv" && ending != ".exr" && !plots)
        throw UsageError(
            fmt::format("{}: unknown ending; expected .csv, .exr, .svg or .png", options.out));
    const bool prints_rows = options.out.empty() && !options.json;
    if (options.inputs.size() > 1 && prints_rows)
        throw UsageError("several inputs: expected -o with .svg or .png, or --json");
    if (options.inputs.size() > 1 && !options.out.empty() && !plots)
        throw UsageError(
            fmt::format("{}: holds one input; only .svg and .png show several", options.out));
    if (!plots && (options.top > 0 || !options.title.empty()))
        throw UsageError("--top and --title: for .svg and .png only");
    for (const std::string& path : options.inputs) // what is wrong with any, before all work
        grid_of(read_input(path, options, globals), options);
    std::vector<Albedo> albedos;
    {
        Progress progress(options.inputs.size(), globals.quiet);
        for (const std::string& path : options.inputs) {
            const ProgressFunction share =
                progress.step(albedos.size(), std::filesystem::path(path).filename().string());
            albedos.push_back(
                albedo_of(read_input(path, options, globals), options, globals, share));
        }
    }
    for (std::size_t i = 0; i < albedos.size(); ++i)
        for (const std::string& note : albedos[i].notes)
            if (note.find("did not reach") != std::string::npos)
                spdlog::warn("{}: {}", options.inputs[i], note);
    const std::string source = std::filesystem::path(options.inputs[0]).filename().string();
    if (plots)
        plot(options, albedos);
    else if (!options.out.empty())
        write_albedo(albedos[0], options.out, source);
    if (prints_rows) {
        fmt::print("{}", albedo_csv(albedos[0], source));
        return 0;
    }
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
    const CLI::Option* const tolerance =
        command
            ->add_option(
                "--tolerance", options->tolerance,
                "absolute error to refine to; of albedos above 1 where that costs too much, "
                "relative")
            ->capture_default_str();
    command->add_option(
        "-o,--output", options->out,
        ".csv or .exr: theta, phi in radians, a column or plane a channel, "
        "<channel>_error; .svg or .png: a plot; without it, and without --json, the .csv is "
        "printed");
    command->add_option("--title", options->title, "of the plot");
    command
        ->add_option("--top", options->top,
                     "largest albedo the plot shows; what is above is cut off and marked")
        ->check(CLI::PositiveNumber);
    command->add_flag("--json", options->json, "print the hemispherical albedo as JSON");
    options->isotropy.add_to(*command);
    command->footer(
        "Examples:\n  brdfit albedo paint.json\n  brdfit albedo paint.json -o albedo.csv\n"
        "  brdfit albedo nickel.binary nickel.kurt.1.json -o albedo.svg");
    command->callback([options, tolerance, &globals, &action] {
        options->tolerance_given = tolerance->count() > 0;
        action = [options, &globals] { return run_albedo(*options, globals); };
    });
}

} // namespace brdfit::cli

#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/cli/progress.hpp"
#include "host/evaluate/klems.hpp"
#include "host/evaluate/tabulate.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

constexpr std::size_t most_nodes = 1024; // of --size, along an axis
// Of tables of scattered samples, whose size is not given; more nodes would only tell of the way
// they are interpolated.
constexpr std::size_t most_scattered_nodes = std::size_t{1} << 18;

struct Options {
    std::string in, out;
    Isotropy isotropy;
    std::vector<std::size_t> size;
    bool spectral = false, zemax = false;
};

/// The size that --size gives.
std::optional<RglSize> size_of(const Options& options, bool isotropic) {
    if (options.size.empty())
        return std::nullopt;
    const std::size_t given = options.size.size(), expected = isotropic ? 2 : 3;
    if (given != expected)
        throw UsageError(fmt::format("--size: {} numbers; expected {} for {}isotropic data", given,
                                     isotropic ? "THETA,SIDE" : "PHI,THETA,SIDE",
                                     isotropic ? "" : "an"));
    const std::size_t phi = isotropic ? 1 : options.size[0];
    for (const std::size_t nodes : options.size)
        if (nodes < 2 || nodes > most_nodes)
            throw UsageError(fmt::format("--size: {}; expected 2 to {}", nodes, most_nodes));
    if (!isotropic && phi < 3)
        throw UsageError("--size: expected at least 3 nodes of phi");
    return RglSize{phi, options.size[given - 2], options.size[given - 1]};
}

/// An RGL file's tables with other channels.
RglTables with_channels(RglTables tables, const RglChannels& channels) {
    const std::size_t nodes = tables.table.count(), before = tables.channels.size();
    std::vector<float> values;
    values.reserve(tables.slices() * channels.source.size() * nodes);
    for (std::size_t slice = 0; slice < tables.slices(); ++slice)
        for (const std::size_t source : channels.source) {
            const auto begin = tables.table.values.begin() +
                               static_cast<std::ptrdiff_t>((slice * before + source) * nodes);
            values.insert(values.end(), begin, begin + static_cast<std::ptrdiff_t>(nodes));
        }
    tables.table.values = std::move(values);
    tables.channels = channels.names;
    tables.wavelengths = channels.wavelengths;
    return tables;
}

/// What a table of scattered samples grows to: small errors beside those of its interpolation.
RglLimits limits_of(const RelativeError& interpolation, std::size_t channels) {
    RglLimits limits;
    limits.enough.median = std::max(limits.enough.median, interpolation.median / 4);
    limits.enough.high = std::max(limits.enough.high, interpolation.high / 4);
    limits.most_bytes = most_scattered_nodes * (channels + 1) * sizeof(float);
    return limits;
}

/// Errors as people read them.
std::string text_of(const RelativeError& error) {
    return fmt::format("{:.3g} % in the median, {:.3g} % at the 95th percentile",
                       100 * error.median, 100 * error.high);
}

/// Writes a material or a measurement as the RGL database's format.
int convert_to_rgl(const Options& options, const Globals& globals) {
    const Brdf brdf = read_brdf(options.in, options.isotropy.choice());
    const MeasuredBrdf* const measured = brdf.measured();
    const bool isotropic = brdf.isotropic();
    const std::optional<RglSize> size = size_of(options, isotropic);
    const RglChannels channels = rgl_channels(brdf.channels(), options.spectral, options.in);
    const std::string name = std::filesystem::path(options.in).filename().string();
    RglTables tables;
    std::string report;
    Progress progress(2, globals.quiet);
    if (measured && measured->tables() != nullptr && !size) {
        tables = with_channels(*measured->tables(), channels);
        report = "the tables of " + options.in;
    } else {
        const Device device = open_device(globals.device);
        const BrdfFunction function = [&](const Directions& directions) {
            return brdf.evaluate(device, directions);
        };
        RglLimits limits;
        std::string against;
        if (measured)
            against = fmt::format(", against {}", measured->method());
        if (measured && measured->scattered() != nullptr) {
            const RelativeError interpolation = measured->scattered()->leave_one_out();
            limits = limits_of(interpolation, channels.source.size());
            against += fmt::format(", which misses a sample that is left out by {}",
                                   text_of(interpolation));
        }
        Tabulated made =
            tabulate(device, function, channels, isotropic, size, limits, progress.step(0, name));
        made.tables.description = fmt::format("{}, by brdfit {}", name, version);
        report = fmt::format("{} x {} x {} x {} nodes of phi_i, theta_i and the square; relative "
                             "error {}{}",
                             made.size.phi_i, made.size.theta_i, made.size.side, made.size.side,
                             text_of(made.error), against);
        tables = std::move(made.tables);
    }
    progress.show(1, options.out);
    rgl::write(tables, options.out);
    progress.clear();
    if (!globals.quiet)
        fmt::print("{}: {}\n", options.out, report);
    return 0;
}

/// What heads texts: where the data is from.
std::vector<std::string> provenance(const Options& options) {
    return {fmt::format("converted by brdfit {}", version),
            fmt::format("source: {}", std::filesystem::path(options.in).filename().string())};
}

/// X, Y and Z of linear R, G and B, whose primaries are those of Rec. 709 with D65 as white.
void make_xyz(std::vector<float>& values) {
    constexpr double from_rgb[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                       {0.2126729, 0.7151522, 0.0721750},
                                       {0.0193339, 0.1191920, 0.9503041}};
    const std::size_t count = values.size() / 3;
    for (std::size_t k = 0; k < count; ++k) {
        const std::array<double, 3> rgb{values[k], values[count + k], values[2 * count + k]};
        for (std::size_t c = 0; c < 3; ++c)
            values[c * count + k] = static_cast<float>(
                from_rgb[c][0] * rgb[0] + from_rgb[c][1] * rgb[1] + from_rgb[c][2] * rgb[2]);
    }
}

int convert_to_zemax(const Options& options, const Globals& globals) {
    const Brdf brdf = read_brdf(options.in, options.isotropy.choice());
    const std::vector<std::string>& channels = brdf.channels();
    const bool rgb = channels == std::vector<std::string>{"R", "G", "B"};
    if (channels.size() != 1 && !rgb && channels != std::vector<std::string>{"X", "Y", "Z"})
        throw InputError(fmt::format("{}: {} channels; a Zemax file has one, or X, Y and Z, which "
                                     "R, G and B become",
                                     options.in, channels.size()));
    const zemax::Grid grid = zemax::written_grid(brdf.isotropic());
    Progress progress(2, globals.quiet);
    std::vector<float> values = brdf.evaluate(
        open_device(globals.device), zemax::directions_of(grid), progress.step(0, "evaluating"));
    if (rgb)
        make_xyz(values);
    progress.show(1, options.out);
    zemax::write(grid, channels.size(), values, options.out, provenance(options));
    progress.clear();
    if (!globals.quiet)
        fmt::print("{}: {} rotations, {} incidences, {} azimuths and {} radial angles\n",
                   options.out, grid.rotations.size(), grid.incidences.size(), grid.azimuths.size(),
                   grid.radials.size());
    return 0;
}

int convert_to_klems(const Options& options, const Globals& globals) {
    const Brdf brdf = read_brdf(options.in, options.isotropy.choice());
    const std::vector<double> weights = klems::luminance_weights(brdf.channels(), options.in);
    const Device device = open_device(globals.device);
    Progress progress(1, globals.quiet);
    const BrdfFunction function = [&](const Directions& directions) {
        return brdf.evaluate(device, directions);
    };
    const std::vector<double> matrix =
        klems::matrix(function, weights, progress.step(0, "evaluating"));
    klems::write(matrix, std::filesystem::path(options.in).stem().string(), options.out);
    progress.clear();
    if (!globals.quiet)
        fmt::print("{}: the luminance over 145 x 145 patches\n", options.out);
    return 0;
}

/// An isotropic RGL file at the centres of MERL's bins.
Samples in_bins(const MeasuredBrdf& measured, const Globals& globals,
                const ProgressFunction& progress) {
    Samples samples;
    samples.source = measured.samples().source;
    samples.channels = measured.channels();
    samples.isotropic = measured.isotropic();
    samples.directions = merl::bin_directions();
    samples.values = measured.evaluate(open_device(globals.device), *samples.directions, progress);
    samples.valid.resize(samples.count());
    for (std::size_t k = 0; k < samples.count(); ++k)
        samples.valid[k] = samples.directions->above_horizon(k);
    return samples;
}

int convert_samples(const Options& options, const Globals& globals) {
    Progress progress(3, globals.quiet);
    progress.show(0, options.in);
    const bool to_merl = std::filesystem::path(options.out).extension() == ".binary";
    if (to_merl && is_measurement(options.in) && rgl::recognise(MappedFile(options.in).bytes())) {
        const MeasuredBrdf measured(options.in, options.isotropy.choice());
        require_merl(measured.samples(), options.out);
        write_samples(in_bins(measured, globals, progress.step(1, "evaluating")), options.out, {},
                      progress.step(2, options.out));
        return 0;
    }
    if (!globals.device.empty())
        throw UsageError("--device: only an output that ends in .bsdf or .xml, or a .binary of an "
                         "RGL file, is made on a device");
    const Samples samples = read_measurement(options.in, options.isotropy.choice());
    write_samples(samples, options.out,
                  {fmt::format("converted from {} by brdfit {}", samples.format, version),
                   fmt::format("source: {}", std::filesystem::path(options.in).filename().string()),
                   fmt::format("sha256: {}", samples.sha256)},
                  progress.step(1, options.out));
    progress.clear();
    spdlog::debug("{}: {} samples", options.out, samples.valid_count());
    return 0;
}

int convert(const Options& options, const Globals& globals) {
    const std::string ending = std::filesystem::path(options.out).extension().string();
    const auto written = {".binary", ".csv", ".astm", ".npy", ".npz", ".bsdf", ".xml"};
    if (std::find(written.begin(), written.end(), ending) == written.end())
        throw UsageError(
            fmt::format("{}: unknown ending; expected {}", options.out, fmt::join(written, ", ")));
    if (options.zemax && ending != ".bsdf")
        throw UsageError("--zemax: expected it with an output that ends in .bsdf");
    if ((!options.size.empty() || options.spectral) && (ending != ".bsdf" || options.zemax))
        throw UsageError("--size, --spectral: expected them with an output that ends in .bsdf, "
                         "and no --zemax");
    if (ending == ".bsdf")
        return options.zemax ? convert_to_zemax(options, globals)
                             : convert_to_rgl(options, globals);
    return ending == ".xml" ? convert_to_klems(options, globals)
                            : convert_samples(options, globals);
}

} // namespace

void add_convert(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("convert", "Write measured reflectance or a material in another format");
    auto options = std::make_shared<Options>();
    command
        ->add_option(
            "IN", options->in,
            "measured reflectance, in any known format; for .bsdf and .xml also a material")
        ->required();
    command
        ->add_option("OUT", options->out,
                     "file to write: .binary (MERL), .csv, .astm, .npy, .npz, .bsdf (RGL: Mitsuba "
                     "3, pbrt-v4) or .xml (Klems matrix: Radiance, WINDOW)")
        ->required();
    command
        ->add_option(
            "--size", options->size,
            "THETA,SIDE or PHI,THETA,SIDE: nodes of a .bsdf; default: what its error asks for")
        ->delimiter(',');
    command->add_flag("--spectral", options->spectral,
                      "a .bsdf with a spectrum, which pbrt-v4 asks for");
    command->add_flag("--zemax", options->zemax, "a .bsdf in Zemax's text, not RGL's format");
    options->isotropy.add_to(*command);
    command->footer("Example:\n  brdfit convert garnet_red.brdf garnet_red.csv\n"
                    "  brdfit convert paint.json paint.bsdf");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return convert(*options, globals); };
    });
}

} // namespace brdfit::cli

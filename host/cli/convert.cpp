#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/cli/progress.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/measured.hpp"
#include "host/evaluate/tabulate.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

constexpr std::size_t most_nodes = 1024; // of --size, along an axis
// Of tables whose size is not given; more of scattered samples would only tell of the way they are
// interpolated.
constexpr std::size_t most_bytes = std::size_t{64} << 20,
                      most_scattered_bytes = std::size_t{4} << 20;

struct Options {
    std::string in, out;
    Isotropy isotropy;
    std::vector<std::size_t> size;
    bool spectral = false;
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

/// Writes a material or a measurement as the RGL database's format.
int convert_to_rgl(const Options& options, const Globals& globals) {
    std::optional<Material> material;
    std::optional<MeasuredBrdf> measured;
    if (is_measurement(options.in)) {
        measured.emplace(options.in, options.isotropy.choice());
    } else {
        if (options.isotropy.choice())
            throw UsageError(fmt::format("--isotropic and --anisotropic: {} is a material; "
                                         "expected them with measured files",
                                         options.in));
        material = read_material(options.in);
    }
    const bool isotropic = material ? material->isotropic() : measured->isotropic();
    const std::optional<RglSize> size = size_of(options, isotropic);
    const RglChannels channels = rgl_channels(material ? material->channels : measured->channels(),
                                              options.spectral, options.in);
    const std::string name = std::filesystem::path(options.in).filename().string();
    RglTables tables;
    std::string report;
    Progress progress(2, globals.quiet);
    if (measured && measured->tables() != nullptr && !size) {
        tables = with_channels(*measured->tables(), channels);
        report = "the tables of " + options.in;
    } else {
        const Device device = open_device(globals.device);
        const BrdfFunction brdf = [&](const Directions& directions) {
            return material ? evaluate(device, *material, directions)
                            : measured->evaluate(device, directions);
        };
        Tabulated made =
            tabulate(device, brdf, channels, isotropic, size,
                     measured && measured->scattered() ? most_scattered_bytes : most_bytes,
                     progress.step(0, name));
        made.tables.description = fmt::format("{}, by brdfit {}", name, version);
        report = fmt::format("{} x {} x {} x {} nodes of phi_i, theta_i and the square; relative "
                             "error {:.2g} % in the median, {:.2g} % at the 95th percentile{}",
                             made.size.phi_i, made.size.theta_i, made.size.side, made.size.side,
                             100 * made.median, 100 * made.high,
                             measured ? fmt::format(", against {}", measured->method()) : "");
        tables = std::move(made.tables);
    }
    progress.show(1, options.out);
    rgl::write(tables, options.out);
    progress.clear();
    if (!globals.quiet)
        fmt::print("{}: {}\n", options.out, report);
    return 0;
}

int convert_samples(const Options& options, const Globals& globals) {
    require_samples_ending(options.out);
    if (!options.size.empty() || options.spectral)
        throw UsageError("--size, --spectral: expected them with an output that ends in .bsdf");
    if (!globals.device.empty())
        throw UsageError("--device: only an output that ends in .bsdf is made on a device");
    Progress progress(2, globals.quiet);
    progress.show(0, options.in);
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
    return std::filesystem::path(options.out).extension() == ".bsdf"
               ? convert_to_rgl(options, globals)
               : convert_samples(options, globals);
}

} // namespace

void add_convert(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("convert", "Write measured reflectance or a material in another format");
    auto options = std::make_shared<Options>();
    command
        ->add_option("IN", options->in,
                     "measured reflectance, in any known format; for .bsdf also a material")
        ->required();
    command
        ->add_option("OUT", options->out,
                     "file to write: .binary (MERL), .csv, .npy or .bsdf (RGL: Mitsuba 3, pbrt-v4)")
        ->required();
    command
        ->add_option(
            "--size", options->size,
            "THETA,SIDE or PHI,THETA,SIDE: nodes of a .bsdf; default: what its error asks for")
        ->delimiter(',');
    command->add_flag("--spectral", options->spectral,
                      "a .bsdf with a spectrum, which pbrt-v4 asks for");
    options->isotropy.add_to(*command);
    command->footer("Example:\n  brdfit convert garnet_red.brdf garnet_red.csv\n"
                    "  brdfit convert paint.json paint.bsdf");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return convert(*options, globals); };
    });
}

} // namespace brdfit::cli

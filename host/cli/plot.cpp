#include "host/image/plot.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/lines.hpp"
#include "host/evaluate/measured.hpp"
#include "host/files/file.hpp"
#include "host/microfacet/table.hpp"
#include "host/render/picture.hpp"
#include "host/render/renderer.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>

namespace brdfit::cli {

namespace {

enum class Kind { Polar, Half, Slice, Distribution };

constexpr std::size_t steps_a_degree = 4, slice_side = 360, most_curves = 64;

struct Options {
    std::vector<std::string> inputs;
    std::vector<double> thetas;
    std::string out, title, channel;
    Kind kind = Kind::Polar;
    double exposure = 0, top = 0;
};

/// A material or a measurement as a function of directions.
class Brdf {
  public:
    explicit Brdf(const std::string& path) : path_(path) {
        if (is_measurement(path))
            measured_.emplace(path);
        else
            material_ = read_material(path);
    }
    const std::vector<std::string>& channels() const {
        return measured_ ? measured_->channels() : material_->channels;
    }
    /// 1/sr, [channel][pair].
    std::vector<float> operator()(const Device& device, const Directions& directions) const {
        return measured_ ? measured_->evaluate(device, directions)
                         : evaluate(device, *material_, directions);
    }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
    std::optional<Material> material_;
    std::optional<MeasuredBrdf> measured_;
};

/// The values of one channel, or their mean over all.
std::vector<double> values_of(const Brdf& brdf, const std::string& channel, const Device& device,
                              const Directions& directions) {
    const std::vector<float> all = brdf(device, directions);
    const std::vector<std::string>& channels = brdf.channels();
    const std::size_t count = directions.count();
    std::size_t first = 0, last = channels.size();
    if (!channel.empty()) {
        first = static_cast<std::size_t>(std::find(channels.begin(), channels.end(), channel) -
                                         channels.begin());
        if (first == last)
            throw UsageError(fmt::format("--channel {}: {} has {}", channel, brdf.path(),
                                         fmt::join(channels, ", ")));
        last = first + 1;
    }
    std::vector<double> values(count);
    for (std::size_t ch = first; ch < last; ++ch)
        for (std::size_t k = 0; k < count; ++k)
            values[k] += all[ch * count + k] / static_cast<double>(last - first);
    return values;
}

void plot_lines(const Options& options, const Globals& globals) {
    const bool polar = options.kind == Kind::Polar;
    std::vector<double> thetas = options.thetas;
    if (thetas.empty())
        thetas = polar ? std::vector<double>{15, 45, 70} : std::vector<double>{10};
    if (thetas.size() * options.inputs.size() > most_curves)
        throw UsageError(fmt::format("{} curves; expected at most {}",
                                     thetas.size() * options.inputs.size(), most_curves));
    const Device device = open_device(globals.device);
    const std::vector<std::string> names = distinct_names(options.inputs);
    std::vector<Curve> curves;
    Progress progress(options.inputs.size(), globals.quiet);
    bool mean = false;
    for (std::size_t i = 0; i < options.inputs.size(); ++i) {
        progress.show(i, names[i]);
        const Brdf brdf(options.inputs[i]);
        mean |= options.channel.empty() && brdf.channels().size() > 1;
        for (const double theta : thetas) {
            Line line =
                polar ? incidence_line(theta, steps_a_degree) : half_line(theta, steps_a_degree);
            Curve curve;
            curve.name = fmt::format("{}, {} {:g}°", names[i], polar ? "θi" : "θd", theta);
            curve.y = values_of(brdf, options.channel, device, line.directions);
            // Below the horizon there is nothing to see.
            for (std::size_t k = 0; k < curve.y.size(); ++k)
                if (!line.directions.above_horizon(k))
                    curve.y[k] = std::nan("");
            curve.x = std::move(line.x);
            curves.push_back(std::move(curve));
        }
    }
    progress.clear();
    PlotOptions plot;
    plot.title = options.title.empty() ? (polar ? "In the plane of incidence" : "Over half vectors")
                                       : options.title;
    if (mean)
        plot.title += " (mean over channels)";
    plot.y_title = "BRDF (1/sr)";
    plot.comment = fmt::format("BRDF in 1/sr, by brdfit {}", version);
    plot.top = options.top;
    if (polar)
        return write_polar_plot(curves, plot, options.out);
    plot.x_title = "half vector from the normal (degrees)";
    plot.logarithmic = true;
    write_plot(curves, plot, options.out);
}

/// BRDF Explorer's image slice: colours over theta_h and theta_d.
void plot_slice(const Options& options, const Globals& globals) {
    if (options.inputs.size() != 1)
        throw UsageError("--kind slice: shows one material or measurement");
    const Device device = open_device(globals.device);
    const Brdf brdf(options.inputs[0]);
    Directions directions(slice_side * slice_side);
    const auto angle = [](std::size_t k) {
        return (static_cast<double>(k) + 0.5) * 90 / slice_side * degree;
    };
    for (std::size_t row = 0; row < slice_side; ++row)
        for (std::size_t column = 0; column < slice_side; ++column) {
            const auto [wi, wo] = half_pair(angle(column), angle(slice_side - 1 - row));
            directions.set(row * slice_side + column, wi, wo);
        }
    const std::vector<float> values = brdf(device, directions);
    Image image;
    image.width = image.height = slice_side;
    image.channels = {"R", "G", "B"};
    for (const std::size_t ch : rgb_channels(brdf.channels(), options.inputs[0]))
        image.planes.emplace_back(
            values.begin() + static_cast<std::ptrdiff_t>(ch * directions.count()),
            values.begin() + static_cast<std::ptrdiff_t>((ch + 1) * directions.count()));
    PlotOptions plot;
    plot.title = options.title.empty() ? distinct_names(options.inputs)[0] : options.title;
    plot.x_title = "half vector from the normal θh (degrees)";
    plot.y_title = "light from the half vector θd (degrees)";
    plot.comment =
        fmt::format("colours of the BRDF times 2^{:g}, by brdfit {}", options.exposure, version);
    write_angle_picture(toned(image, options.exposure, Tone::Clip), plot, options.out);
}

/// What `generate --from` recovered: p over the angle of the half vector, at the azimuth 0.
void plot_distribution(const Options& options) {
    std::vector<Curve> curves;
    const std::vector<std::string> names = distinct_names(options.inputs);
    for (std::size_t i = 0; i < options.inputs.size(); ++i) {
        const std::shared_ptr<const MicrofacetTable> table = read_table(options.inputs[i]);
        const auto& parts = table->distribution.parts;
        if (parts.size() != 1 || parts[0].shape != Shape::Tabulated || !parts[0].table)
            throw InputError(fmt::format("{}: a table of {}; expected one recovered by generate "
                                         "--from, with a tabulated distribution",
                                         options.inputs[i], table->distribution.name));
        Curve curve;
        curve.name = names[i];
        const DirectionTable& values = *parts[0].table;
        for (std::size_t k = 0; k < values.thetas.size(); ++k) {
            curve.x.push_back(values.thetas[k] / degree);
            curve.y.push_back(parts[0].amplitude * values.values[k * values.width]);
        }
        curves.push_back(std::move(curve));
    }
    PlotOptions plot;
    plot.title = options.title.empty() ? "Distribution of microfacet normals" : options.title;
    plot.x_title = "half vector from the normal (degrees)";
    plot.y_title = "p(h) (1/sr)";
    plot.comment = fmt::format("distributions of normals, by brdfit {}", version);
    plot.top = options.top;
    plot.logarithmic = true;
    write_plot(curves, plot, options.out);
}

int plot(const Options& options, const Globals& globals) {
    const std::string ending = std::filesystem::path(options.out).extension().string();
    if (ending != ".svg" && ending != ".png")
        throw UsageError(fmt::format("{}: unknown ending; expected .svg or .png", options.out));
    const bool lines = options.kind == Kind::Polar || options.kind == Kind::Half;
    if (!lines && (!options.thetas.empty() || !options.channel.empty()))
        throw UsageError("--theta and --channel: for --kind polar and half");
    if (options.kind != Kind::Slice && options.exposure != 0)
        throw UsageError("--exposure: for --kind slice");
    if (options.kind == Kind::Slice && options.top > 0)
        throw UsageError("--top: not for --kind slice, which has --exposure");
    if (options.kind == Kind::Distribution && !globals.device.empty())
        throw UsageError("--device: --kind distribution needs no device");
    { const OutputFile probe(options.out); } // a path that cannot be written costs no time
    if (options.kind == Kind::Slice)
        plot_slice(options, globals);
    else if (options.kind == Kind::Distribution)
        plot_distribution(options);
    else
        plot_lines(options, globals);
    return 0;
}

} // namespace

void add_plot(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("plot", "Curves and slices of materials and measurements");
    auto options = std::make_shared<Options>();
    command
        ->add_option(
            "MATERIAL|FILE", options->inputs,
            "material files (.json) and measured reflectance in any known format, over each "
            "other; for --kind distribution tables (.exr) of generate --from")
        ->required();
    command->add_option("-o,--output", options->out, ".svg or .png")->required();
    command
        ->add_option(
            "--kind", options->kind,
            "polar: in the plane of incidence, by its cube root (the default); half: over "
            "the half vector's angle, logarithmic; slice: colours over theta_h and theta_d; "
            "distribution: p(h) that generate --from recovered; directional albedos: brdfit "
            "albedo")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, Kind>{{"polar", Kind::Polar},
                                        {"half", Kind::Half},
                                        {"slice", Kind::Slice},
                                        {"distribution", Kind::Distribution}}))
        ->option_text("NAME");
    command
        ->add_option("--theta", options->thetas,
                     "angles in degrees, a curve each, A,B,...: polar: of the light (default "
                     "15,45,70); half: between light and half vector (10)")
        ->delimiter(',')
        ->check(within(0, 89.9));
    command->add_option("--channel", options->channel, "one channel (default: their mean)");
    command->add_option("--title", options->title, "of the plot");
    command->add_option("--top", options->top, "largest value the plot shows")
        ->check(CLI::PositiveNumber);
    command->add_option("--exposure", options->exposure, "slice: brighter by so many stops")
        ->check(within(-30, 30));
    command->footer(
        "Examples:\n  brdfit plot nickel.binary nickel.kurt.1.json --theta 45 -o nickel.svg\n"
        "  brdfit plot nickel.binary --kind slice -o slice.png\n"
        "  brdfit plot nickel.exr --kind distribution -o p.svg");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return plot(*options, globals); };
    });
}

} // namespace brdfit::cli

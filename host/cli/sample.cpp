#include "host/evaluate/sample.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/files/directions.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>

namespace brdfit::cli {

namespace {

struct Options {
    std::string material, out, wo;
    std::uint64_t n = 0, seed = 0;
    Sequence sequence = Sequence::Sobol;
};

struct Angles {
    double theta, phi; // degrees
};

/// What --wo is where it is THETA,PHI; nothing where it is a file.
std::optional<Angles> angles_of(const std::string& text) {
    const std::size_t comma = std::min(text.find(','), text.size());
    Angles angles{};
    std::error_code unknown;
    if (std::filesystem::is_regular_file(text, unknown) ||
        !CLI::detail::lexical_cast(text.substr(0, comma), angles.theta))
        return std::nullopt;
    if (comma == text.size() || !CLI::detail::lexical_cast(text.substr(comma + 1), angles.phi) ||
        !(angles.theta >= 0 && angles.theta < 90) || !std::isfinite(angles.phi))
        throw UsageError(
            fmt::format("--wo {}: expected THETA,PHI in degrees, THETA from 0 to below "
                        "90, or a file of viewers",
                        text));
    return angles;
}

int sample(const Options& options, const Globals& globals) {
    require_columns_ending(options.out);
    const std::optional<Angles> angles = angles_of(options.wo);
    const Material material = read_material_file(options.material);
    std::vector<Vector> viewers;
    if (angles)
        viewers.push_back(direction(angles->theta * degree, angles->phi * degree));
    else
        viewers = reading(options.wo, FileKind::Directions, read_viewers);
    if (viewers.size() > most_directions / options.n)
        throw UsageError(fmt::format("-n {}: of each of {} viewers; expected at most {} in all",
                                     options.n, viewers.size(), most_directions));
    const Device device = open_device(globals.device);
    std::vector<std::string> names{"wi_x", "wi_y", "wi_z"};
    if (!angles)
        names.insert(names.end(), {"wo_x", "wo_y", "wo_z"});
    names.emplace_back("pdf");
    for (const std::string& channel : material.channels)
        names.push_back("weight_" + channel);
    const std::string viewer =
        angles ? fmt::format("wo at theta {}, phi {} degrees", angles->theta, angles->phi)
               : fmt::format("{} a wo of {}", options.n,
                             std::filesystem::path(options.wo).filename().string());
    const std::size_t rows = viewers.size() * options.n;
    Progress progress(1, globals.quiet);
    const ProgressFunction share =
        progress.step(0, std::filesystem::path(options.out).filename().string());
    ColumnWriter writer(
        options.out, names, rows,
        {fmt::format("light directions drawn for {} from {}, seed {}, by brdfit {}", viewer,
                     std::filesystem::path(options.material).filename().string(), options.seed,
                     version)});
    const Sampler sampler(device, material);
    std::size_t row = 0; // sample i is row i, whatever its viewer
    for (const Vector& wo : viewers)
        for (std::size_t left = options.n; left > 0;) {
            const std::size_t count = std::min(left, sampler.samples_a_pass());
            const DirectionSamples drawn =
                sampler.sample(wo, count, options.seed, options.sequence, row);
            for (std::size_t i = 0; i < count; ++i) {
                for (const float x : {drawn.wi_x[i], drawn.wi_y[i], drawn.wi_z[i]})
                    writer.value(x);
                for (std::size_t k = 0; !angles && k < wo.size(); ++k)
                    writer.value(static_cast<float>(wo[k]));
                writer.value(drawn.pdf[i]);
                for (std::size_t ch = 0; ch < material.channels.size(); ++ch)
                    writer.value(drawn.weight(ch)[i]);
            }
            left -= count;
            row += count;
            share(static_cast<double>(row) / static_cast<double>(rows));
        }
    writer.commit();
    return 0;
}

} // namespace

void add_sample(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("sample", "Draw light directions for viewers, with density and weights");
    auto options = std::make_shared<Options>();
    add_material(*command, options->material);
    command
        ->add_option(
            "--wo", options->wo,
            "viewer: THETA,PHI in degrees, THETA below 90; or a file of viewers: .csv with "
            "wo_x,wo_y,wo_z or .npy of shape (N, 3), or directions as eval takes them")
        ->required();
    command->add_option("-n", options->n, "how many of each viewer")
        ->required()
        ->check(CLI::Range(std::uint64_t{1}, most_directions));
    add_seed(*command, options->seed,
             "another seed, other samples; row i depends on its wo, seed and i alone")
        ->capture_default_str();
    command->add_option("--sequence", options->sequence, "sobol (evenly spread) or philox (random)")
        ->transform(CLI::CheckedTransformer(std::map<std::string, Sequence>{
            {"sobol", Sequence::Sobol}, {"philox", Sequence::Philox}}));
    command
        ->add_option(
            "-o,--output", options->out,
            ".csv or .npy: wi_x,wi_y,wi_z,pdf,weight_<channel>..., for a file of viewers with "
            "wo_x,wo_y,wo_z after wi; weight is f iz / pdf, 0 for a rejected sample")
        ->required();
    command->footer(
        "Examples:\n  brdfit sample paint.json --wo 45,0 -n 1000 --seed 1 -o samples.csv\n"
        "  brdfit sample paint.json --wo viewers.csv -n 16 -o samples.npy");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return sample(*options, globals); };
    });
}

} // namespace brdfit::cli

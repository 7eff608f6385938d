#include "host/evaluate/sample.hpp"
#include "host/cli/command.hpp"
#include "host/files/columns.hpp"
#include "host/version.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string material, out;
    std::vector<double> wo;
    std::uint64_t n = 0, seed = 0;
    Sequence sequence = Sequence::Sobol;
};

int sample(const Options& options, const Globals& globals) {
    const Material material = read_material(options.material);
    const Device device = open_device(globals.device);
    DirectionSamples samples =
        sample_material(device, material, direction(options.wo[0] * degree, options.wo[1] * degree),
                        options.n, options.seed, options.sequence);
    std::vector<std::string> names{"wi_x", "wi_y", "wi_z", "pdf"};
    std::vector<std::vector<float>> columns;
    for (std::size_t ch = 0; ch < material.channels.size(); ++ch)
        names.push_back("weight_" + material.channels[ch]);
    for (std::vector<float>* column : {&samples.wi_x, &samples.wi_y, &samples.wi_z, &samples.pdf})
        columns.push_back(*column);
    for (std::size_t ch = 0; ch < material.channels.size(); ++ch)
        columns.emplace_back(samples.weight(ch), samples.weight(ch) + samples.count());
    write_columns(
        options.out, names, columns,
        {fmt::format(
            "light directions drawn for wo at theta {}, phi {} degrees from {}, seed {}, by "
            "brdfit {}",
            options.wo[0], options.wo[1],
            std::filesystem::path(options.material).filename().string(), options.seed, version)});
    return 0;
}

} // namespace

void add_sample(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "sample", "Draw light directions for a viewer, with density and weights");
    auto options = std::make_shared<Options>();
    add_material(*command, options->material);
    command->add_option("--wo", options->wo, "viewer: THETA,PHI in degrees, THETA below 90")
        ->required()
        ->delimiter(',')
        ->expected(2)
        ->check([](const std::string& text) -> std::string {
            double angle = 0;
            return CLI::detail::lexical_cast(text, angle) && std::isfinite(angle)
                       ? ""
                       : "an angle must be finite";
        });
    command->add_option("-n", options->n, "how many")
        ->required()
        ->check(CLI::Range(std::uint64_t{1}, most_directions));
    add_seed(*command, options->seed,
             "another seed, other samples; sample i depends on seed and i alone")
        ->capture_default_str();
    command->add_option("--sequence", options->sequence, "sobol (evenly spread) or philox (random)")
        ->transform(CLI::CheckedTransformer(std::map<std::string, Sequence>{
            {"sobol", Sequence::Sobol}, {"philox", Sequence::Philox}}));
    command
        ->add_option(
            "-o,--output", options->out,
            ".csv or .npy: wi_x,wi_y,wi_z,pdf,weight_<channel>...; weight is f iz / pdf, 0 "
            "for a rejected sample")
        ->required();
    command->footer(
        "Example:\n  brdfit sample paint.json --wo 45,0 -n 1000 --seed 1 -o samples.csv");
    command->callback([options, &globals, &action] {
        if (!(options->wo[0] >= 0 && options->wo[0] < 90))
            throw CLI::ValidationError("--wo", "THETA must be at least 0 and below 90 degrees");
        action = [options, &globals] { return sample(*options, globals); };
    });
}

} // namespace brdfit::cli

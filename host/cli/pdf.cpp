#include "host/cli/command.hpp"
#include "host/evaluate/sample.hpp"
#include "host/files/columns.hpp"
#include "host/files/directions.hpp"
#include "host/version.hpp"

#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string material, directions, out;
};

int pdf(const Options& options, const Globals& globals) {
    const Material material = read_material(options.material);
    const Directions directions = read_directions(options.directions);
    const Device device = open_device(globals.device);
    write_columns(
        options.out, {"pdf"}, {density(device, material, directions)},
        {fmt::format("density in 1/sr of wi given wo, sampler of {}, by brdfit {}",
                     std::filesystem::path(options.material).filename().string(), version)});
    return 0;
}

} // namespace

void add_pdf(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "pdf", "Density, at directions, of the light directions that sample draws");
    auto options = std::make_shared<Options>();
    add_material(*command, options->material);
    add_directions(*command, options->directions);
    command
        ->add_option("-o,--output", options->out,
                     ".csv or .npy: one column pdf, by solid angle of wi; 0 below the horizon")
        ->required();
    command->footer("Example:\n  brdfit pdf paint.json directions.csv -o pdf.csv");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return pdf(*options, globals); };
    });
}

} // namespace brdfit::cli

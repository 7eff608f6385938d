#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
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
    require_columns_ending(options.out);
    const Material material = read_material_file(options.material);
    Progress progress(3, globals.quiet);
    progress.show(0, options.directions);
    const Directions directions =
        reading(options.directions, FileKind::Directions, read_directions);
    const Device device = open_device(globals.device);
    std::vector<std::vector<float>> columns{
        density(device, material, directions, progress.step(1, "evaluating"))};
    write_columns(
        options.out, {"pdf"}, columns,
        {fmt::format("density in 1/sr of wi given wo, sampler of {}, by brdfit {}",
                     std::filesystem::path(options.material).filename().string(), version)},
        progress.step(2, options.out));
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

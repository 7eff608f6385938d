#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/files/columns.hpp"
#include "host/files/directions.hpp"
#include "host/version.hpp"

#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string file, directions, out;
};

int eval(const Options& options, const Globals& globals) {
    require_columns_ending(options.out);
    const Brdf brdf = read_brdf(options.file);
    Progress progress(3, globals.quiet);
    progress.show(0, options.directions);
    const Directions directions =
        reading(options.directions, FileKind::Directions, read_directions);
    const Device device = open_device(globals.device);
    const std::vector<float> values =
        brdf.evaluate(device, directions, progress.step(1, "evaluating"));
    const std::vector<std::string>& channels = brdf.channels();
    std::vector<std::string> names{"wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"};
    std::vector<std::vector<float>> columns;
    const std::size_t count = directions.count();
    for (std::size_t p = 0; p < names.size(); ++p) {
        const float* const plane = directions.plane(static_cast<Directions::Plane>(p));
        columns.emplace_back(plane, plane + count);
    }
    for (std::size_t ch = 0; ch < channels.size(); ++ch) {
        names.push_back(channels[ch]);
        columns.emplace_back(values.begin() + static_cast<std::ptrdiff_t>(ch * count),
                             values.begin() + static_cast<std::ptrdiff_t>((ch + 1) * count));
    }
    // Without names for columns, the layout of samples.
    if (std::filesystem::path(options.out).extension() == ".npy") {
        names.emplace_back("weight");
        columns.emplace_back(count, 1.0F);
    }
    write_columns(options.out, names, columns,
                  {fmt::format("BRDF in 1/sr of {}, evaluated by brdfit {}",
                               std::filesystem::path(options.file).filename().string(), version)},
                  progress.step(2, options.out));
    return 0;
}

} // namespace

void add_eval(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("eval", "Evaluate a material or a measurement at directions");
    auto options = std::make_shared<Options>();
    command
        ->add_option("FILE", options->file,
                     "material (.json), or measured reflectance in any known format")
        ->required();
    add_directions(*command, options->directions);
    command
        ->add_option("-o,--output", options->out,
                     ".csv or .npy: the directions, then one column a channel; in .npy then "
                     "weight 1, as in samples")
        ->required();
    command->footer("Example:\n  brdfit eval paint.json directions.csv -o values.csv\n"
                    "  brdfit eval paint.bsdf directions.npy -o values.npy");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return eval(*options, globals); };
    });
}

} // namespace brdfit::cli

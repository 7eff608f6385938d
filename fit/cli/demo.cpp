#include "fit/cli/fit_files.hpp"
#include "host/cli/command.hpp"
#include "host/embedded.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/files/file.hpp"
#include "host/measured/write.hpp"

#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

constexpr double demo_noise = 0.02;
constexpr int demo_seed = 1;

// Writes the built-in materials and what a measurement of each would give; fits all models to
// these.
int demo(const std::string& folder, const Globals& globals) {
    const std::filesystem::path truth = std::filesystem::path(folder) / "truth";
    make_output_folder(truth.string());
    const Device device = open_device(globals.device);
    FitRequest request;
    for (const EmbeddedFile* file = embedded_demo; file->name != nullptr; ++file) {
        const Material material = parse_material(file->text, file->name);
        const std::string name = std::filesystem::path(file->name).stem().string();
        const std::string material_file = (truth / file->name).string();
        const std::string measured = (std::filesystem::path(folder) / (name + ".binary")).string();
        write_material(material, material_file);
        if (!globals.quiet)
            fmt::print("$ brdfit synth {} {} --noise {} --seed {}\n", material_file, measured,
                       demo_noise, demo_seed);
        std::fflush(stdout);
        write_samples(synthesise_merl(device, material, demo_noise, demo_seed, material_file),
                      measured);
        request.files.push_back(measured);
    }
    request.models = {"all"};
    request.lobes = {1, 2};
    request.folder = (std::filesystem::path(folder) / "fits").string();
    request.force = true; // the folder is its own
    request.csv = (std::filesystem::path(folder) / "summary.csv").string();
    if (!globals.quiet)
        fmt::print("$ brdfit fit {} -m all --lobes 1,2 -o {} --csv {}\n\n",
                   fmt::join(request.files, " "), request.folder, request.csv);
    std::fflush(stdout);
    return fit_files(request, false, globals);
}

} // namespace

void add_demo(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "demo",
        "Synthesise three measured materials and fit all models to them with one and two lobes");
    auto folder = std::make_shared<std::string>("demo");
    command->add_option("-o,--output", *folder, "folder to write to")->capture_default_str();
    command->footer("Example:\n  brdfit demo -o demo");
    command->callback([folder, &globals, &action] {
        action = [folder, &globals] { return demo(*folder, globals); };
    });
}

} // namespace brdfit::cli

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
int demo(const std::string& folder, bool force, const Globals& globals) {
    const std::filesystem::path root = folder, truth = root / "truth";
    FitRequest request;
    request.models = {"all"};
    request.lobes = {1, 2};
    request.folder = (root / "fits").string();
    request.csv = (root / "summary.csv").string();
    request.force = force;
    std::vector<std::string> inputs;
    for (const EmbeddedFile* file = embedded_demo; file->name != nullptr; ++file) {
        const std::string name = std::filesystem::path(file->name).stem().string();
        request.files.push_back((root / (name + ".binary")).string());
        inputs.push_back(request.files.back());
        inputs.push_back((truth / file->name).string());
    }
    check_nothing_is_replaced(request, inputs);
    make_output_folder(truth.string());
    const Device device = open_device(globals.device);
    for (std::size_t i = 0; i < request.files.size(); ++i) {
        const EmbeddedFile& file = embedded_demo[i];
        const Material material = parse_material(file.text, file.name);
        const std::string material_file = (truth / file.name).string();
        write_material(material, material_file);
        if (!globals.quiet)
            fmt::print("$ brdfit synth {} {} --noise {} --seed {}\n", material_file,
                       request.files[i], demo_noise, demo_seed);
        std::fflush(stdout);
        write_samples(synthesise_merl(device, material, demo_noise, demo_seed, material_file),
                      request.files[i]);
    }
    if (!globals.quiet)
        fmt::print("$ brdfit fit {} -m all --lobes 1,2 -o {} --csv {}{}\n\n",
                   fmt::join(request.files, " "), request.folder, request.csv,
                   force ? " --force" : "");
    std::fflush(stdout);
    return fit_files(request, false, globals);
}

} // namespace

void add_demo(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "demo",
        "Synthesise three measured materials and fit all models to them with one and two lobes");
    struct Options {
        std::string folder = "demo";
        bool force = false;
    };
    auto options = std::make_shared<Options>();
    command->add_option("-o,--output", options->folder, "folder to write to")
        ->capture_default_str();
    command->add_flag("--force", options->force, "replace what is there");
    command->footer("Example:\n  brdfit demo -o demo");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return demo(options->folder, options->force, globals); };
    });
}

} // namespace brdfit::cli

#include "fit/cli/fit_files.hpp"
#include "fit/cli/fit_options.hpp"
#include "host/cli/command.hpp"
#include "host/error.hpp"

#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

struct Options {
    FitSettings settings;
    std::string metric = "ngan", folder, csv;
    bool force = false, json = false;
};

int fit(const Options& options, const Globals& globals) {
    const Metric metric = metric_named(options.metric);
    std::error_code unknown;
    if (!options.csv.empty() && std::filesystem::path(options.csv).extension() != ".csv" &&
        !std::filesystem::is_other(options.csv, unknown)) // a device or a pipe
        throw UsageError(fmt::format("--csv {}: unknown ending; expected .csv", options.csv));
    FitRequest request = options.settings.request();
    request.options.metric = metric;
    request.folder = options.folder;
    request.csv = options.csv;
    request.force = options.force;
    return fit_files(request, options.json, globals);
}

} // namespace

void add_fit(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand("fit", "Fit models to measured reflectance");
    auto options = std::make_shared<Options>();
    options->settings.add_to(*command);
    command->add_option("--metric", options->metric, "what is minimised: ngan, l2, log or cbrt")
        ->capture_default_str();
    command
        ->add_option("-o,--output", options->folder,
                     "folder for the materials, STEM.MODEL.LOBES.json")
        ->required();
    command->add_option("--csv", options->csv, "also write a summary, one row a fit");
    command->add_flag("--force", options->force, "replace materials and summaries that exist");
    command->add_flag("--json", options->json, "print the results as JSON");
    command->footer(
        "Example:\n  brdfit fit nickel.binary -m kurt,ward,kurt+ward --lobes 1,2 -o out");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return fit(*options, globals); };
    });
}

} // namespace brdfit::cli

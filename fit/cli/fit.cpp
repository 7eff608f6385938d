#include "fit/cli/fit_files.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"

#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

struct Options {
    FitRequest request;
    std::string metric = "ngan", algorithm = "slsqp", start;
    std::vector<std::string> fixes, bounds;
    bool json = false, seed_given = false;
    Isotropy isotropy;
};

int fit(Options& options, const Globals& globals) {
    FitRequest& request = options.request;
    request.options.metric = metric_named(options.metric);
    request.options.algorithm = algorithm_named(options.algorithm);
    for (const std::string& text : options.fixes)
        request.options.ranges.push_back(parse_fix(text));
    for (const std::string& text : options.bounds)
        request.options.ranges.push_back(parse_bound(text));
    request.isotropic = options.isotropy.choice();
    if (options.seed_given && request.options.random_starts == 0 &&
        !is_stochastic(request.options.algorithm))
        throw UsageError(fmt::format("--seed: nothing is random with {}; expected it with --starts "
                                     "or a stochastic algorithm",
                                     options.algorithm));
    std::error_code unknown;
    if (!request.csv.empty() && std::filesystem::path(request.csv).extension() != ".csv" &&
        !std::filesystem::is_other(request.csv, unknown)) // a device or a pipe
        throw UsageError(fmt::format("--csv {}: unknown ending; expected .csv", request.csv));
    check(request);
    if (!options.start.empty())
        request.options.start = read_material_file(options.start);
    return fit_files(request, options.json, globals);
}

} // namespace

void add_fit(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand("fit", "Fit models to measured reflectance");
    auto options = std::make_shared<Options>();
    FitRequest& request = options->request;
    command->add_option("FILE", request.files, "measured reflectance, in any known format")
        ->required();
    command
        ->add_option("-m,--model", request.models,
                     "models, with commas between; a+b is a mixture of two lobes; all: every model")
        ->required()
        ->allow_extra_args(false) // what follows may be a file
        ->delimiter(',');
    command
        ->add_option("-o,--output", request.folder,
                     "folder for the materials, STEM.MODEL.LOBES.json")
        ->required();
    command->add_option("--lobes", request.lobes, "numbers of lobes, 1 to 4, with commas between")
        ->allow_extra_args(false)
        ->delimiter(',')
        ->check(CLI::Range(1, static_cast<int>(max_lobes)))
        ->default_str("1");
    command->add_option("--diffuse", request.diffuse, "diffuse shape (default: lambert)");
    command->add_option("--metric", options->metric, "what is minimised: ngan, l2, log or cbrt")
        ->capture_default_str();
    command
        ->add_option("--max-theta", request.options.max_theta,
                     "drop samples beyond this angle from the normal, degrees")
        ->check(within(1, 90))
        ->capture_default_str();
    command->add_option("--algorithm", options->algorithm, "NLopt algorithm for the polish")
        ->capture_default_str();
    command->add_option("--max-evaluations", request.options.max_evaluations, "of one polish")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    command
        ->add_option("--starts", request.options.random_starts,
                     "random starts polished besides the global search")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    const CLI::Option* const seed =
        add_seed(*command, request.options.seed, "of the random starts and stochastic algorithms")
            ->capture_default_str();
    command->add_option("--start", options->start,
                        "material to start from, in place of the global search");
    command
        ->add_option("--fix", options->fixes,
                     "fix a parameter: f0=0.04, m=0.1, 2.alpha=0 (of the second lobe)")
        ->allow_extra_args(false);
    command->add_option("--bound", options->bounds, "narrow a parameter's range: alpha=0:1")
        ->allow_extra_args(false);
    command->add_flag("--conserve", request.options.conserve,
                      "only materials that reflect no more light than they receive, up to 89 "
                      "degrees");
    command->add_option("--csv", request.csv, "also write a summary, one row a fit");
    command->add_flag("--force", request.force, "replace materials and summaries that exist");
    command->add_flag("--json", options->json, "print the results as JSON");
    options->isotropy.add_to(*command);
    command->footer(
        "Example:\n  brdfit fit nickel.binary -m kurt,ward,kurt+ward --lobes 1,2 -o out");
    command->callback([options, seed, &globals, &action] {
        options->seed_given = seed->count() > 0;
        action = [options, &globals] { return fit(*options, globals); };
    });
}

} // namespace brdfit::cli

#include "fit/cli/fit_options.hpp"

#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"

#include <fmt/format.h>

namespace brdfit::cli {

void FitSettings::add_to(CLI::App& command) {
    FitOptions& options = request_.options;
    command.add_option("FILE", request_.files, "measured reflectance, in any known format")
        ->required();
    command
        .add_option("-m,--model", request_.models,
                    "models, with commas between; a+b is a mixture of two lobes; all: every model")
        ->required()
        ->allow_extra_args(false) // what follows may be a file
        ->delimiter(',');
    command.add_option("--lobes", request_.lobes, "numbers of lobes, 1 to 4, with commas between")
        ->allow_extra_args(false)
        ->delimiter(',')
        ->check(CLI::Range(1, static_cast<int>(max_lobes)))
        ->default_str("1");
    command.add_option("--diffuse", request_.diffuse, "diffuse shape (default: lambert)");
    command
        .add_option("--max-theta", options.max_theta,
                    "drop samples beyond this angle from the normal, degrees")
        ->check(within(1, 90))
        ->capture_default_str();
    command.add_option("--algorithm", algorithm_, "NLopt algorithm for the polish")
        ->capture_default_str();
    command.add_option("--max-evaluations", options.max_evaluations, "of one polish")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    command
        .add_option("--starts", options.random_starts,
                    "random starts tried besides the global search")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    seed_ = add_seed(command, options.seed, "of the random starts and stochastic algorithms")
                ->capture_default_str();
    command.add_option("--start", start_, "material to start from, in place of the global search");
    command
        .add_option("--fix", fixes_,
                    "fix a parameter: f0=0.04, m=0.1, 2.alpha=0 (of the second lobe)")
        ->allow_extra_args(false);
    command.add_option("--bound", bounds_, "narrow a parameter's range: alpha=0:1")
        ->allow_extra_args(false);
    command.add_flag("--conserve", options.conserve,
                     "only materials that reflect no more light than they receive, up to 89 "
                     "degrees");
    command.add_flag("--orient", request_.orient,
                     "also fit how each lobe is turned about the normal, where the data is "
                     "anisotropic");
    isotropy_.add_to(command);
}

FitRequest FitSettings::request() const {
    FitRequest request = request_;
    FitOptions& options = request.options;
    options.algorithm = algorithm_named(algorithm_);
    for (const std::string& text : fixes_)
        options.ranges.push_back(parse_fix(text));
    for (const std::string& text : bounds_)
        options.ranges.push_back(parse_bound(text));
    request.isotropic = isotropy_.choice();
    if (seed_->count() > 0 && options.random_starts == 0 && !is_stochastic(options.algorithm))
        throw UsageError(fmt::format("--seed: nothing is random with {}; expected it with --starts "
                                     "or a stochastic algorithm",
                                     algorithm_));
    if (!start_.empty())
        options.start = read_material_file(start_);
    check(request);
    return request;
}

} // namespace brdfit::cli

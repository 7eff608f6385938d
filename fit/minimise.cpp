#include "fit/minimise.hpp"

#include "host/error.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <nlopt.h>

namespace brdfit {

namespace {

std::string upper_case(std::string text) {
    for (char& c : text)
        c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

// What the callback shares with minimise: the function, the best point, and why it stopped.
struct Minimisation {
    const Function& function;
    nlopt_opt optimiser;
    double scale; // the value at the start, so that NLopt sees values of about 1
    int patience;
    Minimum best;
    std::exception_ptr failure;
    std::vector<double> x, gradient;
    int in_vain = 0; // evaluations in a row
};

// Whether this NLopt was built with the algorithm: without, it refuses to run.
bool is_built_in(nlopt_algorithm algorithm) {
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(nlopt_create(algorithm, 2),
                                                                      nlopt_destroy);
    if (!optimiser)
        return false;
    const auto square = [](unsigned, const double* x, double* gradient, void*) {
        if (gradient != nullptr) {
            gradient[0] = 2 * x[0];
            gradient[1] = 2 * x[1];
        }
        return x[0] * x[0] + x[1] * x[1];
    };
    double x[2] = {0.5, 0.25}, value = 0;
    nlopt_set_min_objective(optimiser.get(), square, nullptr);
    nlopt_set_lower_bounds1(optimiser.get(), -1);
    nlopt_set_upper_bounds1(optimiser.get(), 1);
    nlopt_set_maxeval(optimiser.get(), 1);
    return nlopt_optimize(optimiser.get(), x, &value) != NLOPT_INVALID_ARGS;
}

double evaluate_for_nlopt(unsigned n, const double* x, double* gradient, void* data) {
    Minimisation& search = *static_cast<Minimisation*>(data);
    constexpr double very_bad = 1e10; // finite: see minimise.hpp
    double value = very_bad;
    if (search.failure ||
        (search.patience > 0 &&
         search.in_vain >= search.patience)) { // some algorithms go on after nlopt_force_stop
        if (gradient != nullptr)
            std::fill(gradient, gradient + n, 0.0);
        return very_bad;
    }
    try {
        search.x.assign(x, x + n);
        value = search.function(search.x, gradient != nullptr ? &search.gradient : nullptr);
        ++search.best.evaluations;
    } catch (...) {
        search.failure = std::current_exception();
        nlopt_force_stop(search.optimiser);
    }
    if (value < search.best.value * (1 - MinimiseOptions::least_gain))
        search.in_vain = 0;
    else if (search.x != search.best.x && ++search.in_vain == search.patience)
        nlopt_force_stop(search.optimiser);
    bool usable = !search.failure && std::isfinite(value);
    if (usable && gradient != nullptr)
        for (unsigned i = 0; i < n; ++i)
            usable = usable && std::isfinite(search.gradient[i]);
    if (!usable) {
        if (gradient != nullptr)
            std::fill(gradient, gradient + n, 0.0);
        return very_bad;
    }
    if (value < search.best.value) {
        search.best.value = value;
        search.best.x = search.x;
    }
    if (gradient != nullptr)
        for (unsigned i = 0; i < n; ++i)
            gradient[i] = search.gradient[i] / search.scale;
    return value / search.scale;
}

} // namespace

std::string algorithm_named(const std::string& name) {
    const std::string wanted = upper_case(name);
    std::string known;
    for (int i = 0; i < NLOPT_NUM_ALGORITHMS; ++i) {
        std::string full = nlopt_algorithm_to_string(static_cast<nlopt_algorithm>(i));
        // These need a second algorithm, and give up where that one meets round-off.
        if (full.find("MLSL") != std::string::npos || full.find("AUGLAG") != std::string::npos)
            continue;
        const std::string shorter = full.substr(full.find('_') + 1);
        if (!is_built_in(static_cast<nlopt_algorithm>(i)))
            continue;
        if (wanted == full || wanted == shorter)
            return full;
        known += (known.empty() ? "" : ", ") + shorter;
    }
    std::transform(known.begin(), known.end(), known.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    throw UsageError(fmt::format("unknown algorithm '{}'; known: {}", name, known));
}

bool is_stochastic(const std::string& algorithm) {
    constexpr std::array drawing{"CRS2", "ISRES", "ESCH", "RAND"};
    return std::any_of(drawing.begin(), drawing.end(),
                       [&](const char* part) { return algorithm.find(part) != std::string::npos; });
}

Minimum minimise(const Function& function, const std::vector<double>& start,
                 const std::vector<double>& lower, const std::vector<double>& upper,
                 const MinimiseOptions& options) {
    Minimum none{start, std::numeric_limits<double>::infinity(), 0};
    if (start.empty()) {
        const double value = function(start, nullptr);
        return {start, std::isfinite(value) ? value : none.value, 1};
    }
    const nlopt_algorithm algorithm = nlopt_algorithm_from_string(options.algorithm.c_str());
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(
        nlopt_create(algorithm, static_cast<unsigned>(start.size())), nlopt_destroy);
    if (!optimiser)
        throw UsageError(fmt::format("NLopt has no algorithm {}", options.algorithm));
    Minimisation search{function, optimiser.get(), 1, options.patience, none, nullptr, {}, {}};
    const double first = function(start, nullptr);
    search.best.evaluations = 1;
    if (std::isfinite(first)) {
        search.best.value = first;
        if (first > 0)
            search.scale = first;
    }
    nlopt_set_min_objective(optimiser.get(), evaluate_for_nlopt, &search);
    nlopt_set_lower_bounds(optimiser.get(), lower.data());
    nlopt_set_upper_bounds(optimiser.get(), upper.data());
    nlopt_set_ftol_rel(optimiser.get(), options.relative_tolerance);
    nlopt_set_xtol_rel(optimiser.get(), 1e-9);
    nlopt_set_maxeval(optimiser.get(), std::max(1, options.max_evaluations));
    nlopt_srand(options.seed); // its generator is per thread, and seeded by the clock otherwise
    std::vector<double> x(start);
    for (std::size_t i = 0; i < x.size(); ++i)
        x[i] = std::clamp(x[i], lower[i], upper[i]);
    double value = 0;
    const nlopt_result result = nlopt_optimize(optimiser.get(), x.data(), &value);
    if (search.failure)
        std::rethrow_exception(search.failure);
    if (result == NLOPT_INVALID_ARGS || result == NLOPT_OUT_OF_MEMORY) {
        const char* const why = nlopt_get_errmsg(optimiser.get());
        throw UsageError(fmt::format("{} cannot be used here: {}", options.algorithm,
                                     why != nullptr ? why : "invalid arguments"));
    }
    return search.best;
}

} // namespace brdfit

// The part of FileFitter that doubts its search.
#include "fit/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace brdfit {

namespace {

// A random start beats the search where its error is below by more than this share.
constexpr double better_share = 1e-3;
// Minima of the thinned samples are worth a polish on all where their squared error is no more than
// this many times the fit's there.
constexpr double worst_worth = 2.25;

} // namespace

void FileFitter::try_random_starts(const Structure& structure, const Fitted& fit,
                                   Conserving* conserved, Solution& solution, FitResult& result,
                                   const ProgressFunction& progress) {
    struct Optimum {
        std::vector<double> theta; // on the thinned samples
        bool beats;                // the search's, on all
    };
    std::vector<Optimum> known;
    Objective &thinned = thinned_objective(structure), &all = full_objective(structure);
    const std::size_t before = thinned.evaluations();
    if (conserved != nullptr) // as `all` is
        thinned.limit_albedos(conserved->limit);
    Polish on_thinned = thinned_polish(structure, fit.space);
    Polish on_all = full_polish(structure, fit.space);
    const double worth = worst_worth * on_thinned.descended(fit.solution).squared_error;
    const auto beats_the_search = [&](const Solution& start) {
        Solution other = best_of(on_all, {start}, fit.solution.squared_error);
        if (conserved != nullptr && better(other, solution))
            other = settled(all, *conserved, std::move(other));
        const double error = std::sqrt(other.squared_error);
        if (better(other, solution))
            solution = std::move(other);
        return error < std::sqrt(fit.solution.squared_error) * (1 - better_share);
    };
    for (int i = 0; i < options_.random_starts; ++i) {
        tell(progress, (i + 1.0) / (options_.random_starts + 1)); // the search is one, about
        const std::vector<double> random =
            fit.space.random(options_.seed, static_cast<std::uint64_t>(i));
        const Solution start = thinned_minimum(on_thinned, structure, fit.space, {random, {}, 0});
        if (!(start.squared_error <= worth))
            continue;
        auto optimum = std::find_if(known.begin(), known.end(), [&](const Optimum& other) {
            return alike(fit.space, start.theta, other.theta);
        });
        if (optimum == known.end())
            optimum = known.insert(optimum, {start.theta, beats_the_search(start)});
        result.random_starts_better += optimum->beats ? 1 : 0;
    }
    result.random_starts = options_.random_starts;
    result.thinned_evaluations += thinned.evaluations() - before;
    thinned.limit_albedos(nullptr);
}

} // namespace brdfit

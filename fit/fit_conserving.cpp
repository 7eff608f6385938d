// The part of FileFitter that makes fits conserve energy.
#include "fit/fit.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace brdfit {

namespace {

// Where a fit that is to conserve energy looks at R first, degrees; points of an albedo while it is
// polished; how often viewers are added.
const std::vector<double> first_viewers{0, 40, 70, 85, 89};
constexpr std::uint32_t limit_points = 8192;
constexpr int most_limit_rounds = 8;

} // namespace

Solution FileFitter::best_conserving(const Structure& structure, Conserving& found) {
    const Space& space = found.fitted.space;
    std::vector<Solution> starts{found.fitted.solution};
    if (!options_.start) {
        Objective& thinned = thinned_objective(structure);
        const std::size_t before = thinned.evaluations();
        const std::vector<StartingPoint> searched = searched_starts(structure, space);
        thinned.start_near(found.fitted.solution.a); // whichever fitter has fitted it freely
        thinned.limit_albedos(found.limit);
        const std::vector<Solution> polished = polished_thinned(structure, space, searched);
        thinned.limit_albedos(nullptr);
        found.fitted.thinned_evaluations += thinned.evaluations() - before;
        const std::vector<Solution> best = distinct(space, polished, finalist_count(structure));
        starts.insert(starts.end(), best.begin(), best.end());
        for (const Smaller& part : smaller_than(structure))
            starts.push_back(
                extended(structure, space, part, conserving(part.structure).fitted.solution));
    }
    Objective& objective = full_objective(structure);
    const std::size_t before = objective.evaluations();
    objective.start_near(found.fitted.solution.a);
    objective.limit_albedos(found.limit);
    Polish polish = full_polish(structure, space);
    for (Solution& start : starts)
        start = polish.minimised(start);
    std::stable_sort(starts.begin(), starts.end(), better);
    Solution best;
    best.squared_error = std::numeric_limits<double>::infinity();
    // More viewers make no solution better: the others are done with where one is settled below.
    for (Solution& start : starts)
        if (better(start, best)) {
            Solution solution = settled(objective, found, std::move(start));
            if (better(solution, best))
                best = std::move(solution);
        }
    found.fitted.evaluations += objective.evaluations() - before;
    return best;
}

Solution FileFitter::settled(Objective& objective, Conserving& found, Solution solution) {
    AlbedoLimit all = limit_at_every_degree(found.limit->albedos, solution.theta, solution.a);
    const auto degrees = static_cast<Eigen::Index>(conserved_theta) + 1;
    Eigen::MatrixXd components = all.at(solution.theta);
    for (int round = 0; round < most_limit_rounds; ++round) {
        const Eigen::MatrixXd r = material_albedos(solution.a, components);
        std::vector<Vector> violated;
        for (Eigen::Index ch = 0; ch < r.rows(); ++ch)
            for (Eigen::Index first = 0; first < r.cols(); first += degrees) {
                Eigen::Index at = 0;
                if (r.row(ch).segment(first, degrees).maxCoeff(&at) > 1 + conserved_tolerance)
                    violated.push_back(all.wo[static_cast<std::size_t>(first + at)]);
            }
        if (violated.empty())
            break;
        std::vector<Vector>& wo = found.limit->wo;
        const std::size_t before = wo.size();
        for (const Vector& w : violated)
            if (std::find(wo.begin(), wo.end(), w) == wo.end())
                wo.push_back(w);
        if (wo.size() == before)
            break; // as close as albedos that are smooth in theta can tell
        solution = full_polish(objective.structure(), found.fitted.space).minimised(solution);
        components = all.at(solution.theta);
    }
    objective.limit_albedos(std::make_shared<const AlbedoLimit>(all));
    if (quadratic(options_.metric)) {
        solution.squared_error = objective.projected_error(solution.theta);
        solution.a = objective.coefficients();
    } else {
        solution.squared_error =
            objective.projected_loss(options_.metric, solution.theta, solution.a);
    }
    objective.limit_albedos(found.limit);
    return solution;
}

FileFitter::Conserving& FileFitter::conserving(const Structure& structure) {
    return *shared_->conserving.get(structure.key(), [&] {
        auto found = std::make_shared<Conserving>(Conserving{
            fitted(structure),
            std::make_shared<AlbedoLimit>(AlbedoLimit{
                ComponentAlbedos(programs_, structure),
                viewers_at(first_viewers, structure, 3, fitted(structure).solution.theta),
                limit_points})});
        make_conserving(structure, *found);
        return found;
    });
}

void FileFitter::make_conserving(const Structure& structure, Conserving& found) {
    const auto started = std::chrono::steady_clock::now();
    const double building = programs_.build_seconds();
    const Solution& free = found.fitted.solution;
    const Eigen::MatrixXd r = material_albedos(
        free.a, limit_at_every_degree(found.limit->albedos, free.theta, free.a).at(free.theta));
    if (r.maxCoeff() > 1 + conserved_tolerance / 2)
        found.fitted.solution = best_conserving(structure, found);
    const auto taken = std::chrono::steady_clock::now() - started;
    found.fitted.polish_seconds +=
        std::chrono::duration<double>(taken).count() - (programs_.build_seconds() - building);
}

} // namespace brdfit

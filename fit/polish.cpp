#include "fit/polish.hpp"

#include "fit/gauss_newton.hpp"
#include "fit/levenberg_marquardt.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace brdfit {

namespace {

// Evaluations that NLopt may spend at the result of a descent without a gain.
constexpr int patience_at_optimum = 2;

} // namespace

Polish::Polish(Objective& objective, const Space& space, Metric metric, MinimiseOptions options)
    : objective_(objective), space_(space), metric_(metric), options_(std::move(options)) {}

Solution Polish::descended(const Solution& start, double goal) {
    if (!can_descend())
        return minimised(start);
    if (start.a.size() > 0)
        objective_.start_near(start.a);
    Known best{{start.theta, start.a, std::numeric_limits<double>::infinity()}, {}, {}, 0};
    std::vector<double> by_theta;
    NormalSums sums;
    const ExpandedFunction expanded = [&](const std::vector<double>& x) {
        const std::vector<double> theta = space_.to_theta(x);
        Expansion at{objective_.projected_normal(theta, by_theta, sums), {}, {}};
        if (!std::isfinite(at.value))
            return at;
        const Coefficients& a = objective_.coefficients();
        const std::vector<double> gradient = space_.gradient_by_x(theta, by_theta);
        at.gradient = Eigen::Map<const Eigen::VectorXd>(gradient.data(),
                                                        static_cast<Eigen::Index>(gradient.size()));
        at.curvature = space_.curvature_by_x(
            theta, 2 * projected(gauss_newton(sums, objective_.layout(), a), a));
        if (at.value < best.solution.squared_error)
            best = {{theta, a, at.value}, x, gradient, 0};
        return at;
    };
    DescentOptions options;
    options.max_evaluations = options_.max_evaluations;
    options.relative_tolerance = std::max(options_.relative_tolerance, options.relative_tolerance);
    options.goal = goal;
    best.evaluations = levenberg_marquardt(expanded, space_.to_x(start.theta), space_.lower(),
                                           space_.upper(), options)
                           .evaluations;
    known_.push_back(best);
    return best.solution;
}

// NLopt sees theta alone: kd and ks are solved for each theta, where the metric is not quadratic
// from those of the last theta.
Solution Polish::minimised(const Solution& start) {
    const auto known = std::find_if(known_.begin(), known_.end(), [&](const Known& k) {
        return k.solution.theta == start.theta;
    });
    MinimiseOptions options = options_;
    if (known != known_.end()) {
        options.max_evaluations -= known->evaluations;
        options.patience = patience_at_optimum;
    }
    if (quadratic(metric_) && start.a.size() > 0)
        objective_.start_near(start.a);
    Solution best{start.theta, start.a, std::numeric_limits<double>::infinity()};
    Coefficients a = start.a;
    std::vector<double> by_theta;
    const Function error = [&](const std::vector<double>& x, std::vector<double>* gradient) {
        if (known != known_.end() && x == known->x) {
            best = known->solution;
            if (gradient != nullptr)
                *gradient = known->gradient;
            return best.squared_error;
        }
        const std::vector<double> theta = space_.to_theta(x);
        std::vector<double>* const wanted = gradient != nullptr ? &by_theta : nullptr;
        const double value = quadratic(metric_)
                                 ? objective_.projected_error(theta, wanted)
                                 : objective_.projected_loss(metric_, theta, a, wanted);
        if (gradient != nullptr)
            *gradient = space_.gradient_by_x(theta, by_theta);
        if (value < best.squared_error)
            best = {theta, quadratic(metric_) ? objective_.coefficients() : a, value};
        return value;
    };
    minimise(error, known != known_.end() ? known->x : space_.to_x(start.theta), space_.lower(),
             space_.upper(), options);
    if (known == known_.end() && quadratic(metric_) && std::isfinite(best.squared_error)) {
        // Without a gradient, from sums in which nothing cancels.
        best.squared_error = objective_.projected_error(best.theta);
        best.a = objective_.coefficients();
    }
    return best;
}

} // namespace brdfit

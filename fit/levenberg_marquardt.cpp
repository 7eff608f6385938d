#include "fit/levenberg_marquardt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace brdfit {

namespace {

// Damping as a share of the curvature: after a first step that failed; below the least it is none;
// beyond the most no step is worth a try.
constexpr double first_damping = 0.1, least_damping = 1e-3, most_damping = 1e8;
// The share of the promised fall from which damping is lowered, and below which it is raised.
constexpr double good_share = 0.75, poor_share = 0.25;
// A curvature below this share of the largest counts as that: a parameter without effect.
constexpr double least_curvature = 1e-12;
// A step that promises less than this share of the value and fails has met rounding.
constexpr double rounding_share = 1e-6;
// Steps to come gain less than so many times what the next one promises.
constexpr double reach = 10;

struct Box {
    Eigen::VectorXd lower, upper;
};

// The quadratic model's minimum within the box of steps, from active sets: the most violated bound
// becomes an equation, one whose multiplier pulls inwards is let go. False where the curvature of
// what is free is not positive.
bool best_step(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& curvature, const Box& box,
               Eigen::VectorXd& step) {
    const Eigen::Index n = gradient.size();
    std::vector<bool> bound(static_cast<std::size_t>(n), false);
    const auto is_bound = [&](Eigen::Index i) { return bound[static_cast<std::size_t>(i)]; };
    step = Eigen::VectorXd::Zero(n);
    for (Eigen::Index round = 0; round < 3 * n + 3; ++round) {
        std::vector<Eigen::Index> free;
        for (Eigen::Index i = 0; i < n; ++i)
            if (!is_bound(i))
                free.push_back(i);
        const auto m = static_cast<Eigen::Index>(free.size());
        Eigen::MatrixXd of_free(m, m);
        Eigen::VectorXd right(m);
        for (Eigen::Index i = 0; i < m; ++i) {
            const Eigen::Index row = free[static_cast<std::size_t>(i)];
            right[i] = -gradient[row];
            for (Eigen::Index k = 0; k < n; ++k)
                if (is_bound(k))
                    right[i] -= curvature(row, k) * step[k];
            for (Eigen::Index k = 0; k < m; ++k)
                of_free(i, k) = curvature(row, free[static_cast<std::size_t>(k)]);
        }
        const Eigen::LLT<Eigen::MatrixXd> decomposition(of_free);
        if (decomposition.info() != Eigen::Success)
            return false;
        const Eigen::VectorXd found = decomposition.solve(right);
        if (!found.allFinite())
            return false;
        Eigen::Index worst = -1;
        double most = 0;
        for (Eigen::Index i = 0; i < m; ++i) {
            const Eigen::Index at = free[static_cast<std::size_t>(i)];
            step[at] = found[i];
            const double beyond = std::max(box.lower[at] - found[i], found[i] - box.upper[at]);
            if (beyond > most) {
                most = beyond;
                worst = at;
            }
        }
        if (worst >= 0) {
            bound[static_cast<std::size_t>(worst)] = true;
            step[worst] = std::clamp(step[worst], box.lower[worst], box.upper[worst]);
            continue;
        }
        const Eigen::VectorXd slope = gradient + curvature * step;
        Eigen::Index released = -1;
        for (Eigen::Index i = 0; i < n; ++i)
            if (is_bound(i) && box.lower[i] < box.upper[i] &&
                (step[i] <= box.lower[i] ? slope[i] < 0 : slope[i] > 0) &&
                (released < 0 || std::abs(slope[i]) > std::abs(slope[released])))
                released = i;
        if (released < 0)
            return true;
        bound[static_cast<std::size_t>(released)] = false;
    }
    step = step.cwiseMax(box.lower).cwiseMin(box.upper);
    return true;
}

// Adds what the step tells of the Hessian without Gauss-Newton's curvature `known` at its end.
void learn(Eigen::MatrixXd& rest, const Eigen::MatrixXd& known, const Eigen::VectorXd& step,
           const Eigen::VectorXd& change) {
    const double along = change.dot(step);
    const double scale = step.norm() * change.norm();
    if (!(std::abs(along) > 1e-8 * scale))
        return;
    const Eigen::VectorXd wanted = change - known * step;
    // What was learned far away may be too large here.
    const double before = std::abs(step.dot(rest * step)), now = std::abs(step.dot(wanted));
    if (before > now)
        rest *= now / before;
    const Eigen::VectorXd missing = wanted - rest * step;
    rest += (missing * change.transpose() + change * missing.transpose()) / along -
            (missing.dot(step) / (along * along)) * change * change.transpose();
}

bool is_finite(const Expansion& e) {
    return std::isfinite(e.value) && e.gradient.allFinite() && e.curvature.allFinite();
}

} // namespace

Minimum levenberg_marquardt(const ExpandedFunction& function, const std::vector<double>& start,
                            const std::vector<double>& lower, const std::vector<double>& upper,
                            const DescentOptions& options) {
    const auto n = static_cast<Eigen::Index>(start.size());
    const Eigen::Map<const Eigen::VectorXd> low(lower.data(), n), high(upper.data(), n);
    Minimum best{start, std::numeric_limits<double>::infinity(), 0};
    for (std::size_t i = 0; i < start.size(); ++i)
        best.x[i] = std::clamp(start[i], lower[i], upper[i]);
    Expansion at = function(best.x);
    best.evaluations = 1;
    if (!is_finite(at))
        return best;
    best.value = at.value;
    Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(n, n);
    double damping = 0;
    while (n > 0 && best.evaluations < options.max_evaluations && damping < most_damping) {
        const Eigen::Map<const Eigen::VectorXd> x(best.x.data(), n);
        const Box box{low - x, high - x};
        const double largest = at.curvature.diagonal().maxCoeff();
        const Eigen::VectorXd scale =
            at.curvature.diagonal().cwiseMax(std::max(least_curvature * largest, 1e-300));
        Eigen::MatrixXd model = at.curvature + rest;
        Eigen::VectorXd step;
        const Eigen::MatrixXd damped = damping * Eigen::MatrixXd(scale.asDiagonal());
        if (!best_step(at.gradient, model + damped, box, step)) {
            model = at.curvature;
            if (!best_step(at.gradient, model + damped, box, step)) {
                damping = std::max(10 * damping, least_damping);
                continue;
            }
        }
        const double promised = -step.dot(at.gradient) - 0.5 * step.dot(model * step);
        if (!(promised > options.relative_tolerance * at.value) ||
            at.value - reach * promised > options.goal)
            break;
        std::vector<double> there(best.x);
        for (std::size_t i = 0; i < there.size(); ++i)
            there[i] =
                std::clamp(there[i] + step[static_cast<Eigen::Index>(i)], lower[i], upper[i]);
        Expansion tried = function(there);
        ++best.evaluations;
        const bool better = is_finite(tried) && tried.value < at.value;
        if (!better) {
            if (promised < rounding_share * at.value)
                break;
            damping = std::max(10 * damping, first_damping);
            continue;
        }
        learn(rest, tried.curvature, step, tried.gradient - at.gradient);
        const double share = (at.value - tried.value) / promised;
        if (share > good_share)
            damping = damping < 10 * least_damping ? 0 : 0.1 * damping;
        else if (share < poor_share)
            damping = std::max(4 * damping, 10 * least_damping);
        best.x = std::move(there);
        best.value = tried.value;
        at = std::move(tried);
    }
    return best;
}

} // namespace brdfit

#include "fit/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

// A parameter this close to the end of its range, as a share of it, ended at a bound.
constexpr double bound_share = 1e-6;
// Directions of less curvature than this share of what each parameter has alone are not determined:
// sums of float32 products tell no less.
constexpr double undetermined = 3e-7;
// kd and ks below this share of the largest are 0, as optimisers leave it.
constexpr double nothing_share = 1e-9;

bool ended_at_bound(const Space::Dimension& dimension, double value) {
    const Parameter& p = dimension.parameter;
    const double low = to_scale(p.scale, p.lower), high = to_scale(p.scale, p.upper);
    const double x = to_scale(p.scale, value);
    const double margin = bound_share * (high - low);
    return !dimension.fixed && (x <= low + margin || x >= high - margin);
}

// J'J of the mean squared error by theta and, channel after channel, kd and ks.
Eigen::MatrixXd gauss_newton(Objective& objective, const std::vector<double>& theta,
                             const Coefficients& a, double& squared_error) {
    const NormalSums normal = objective.normal_sums(theta, a);
    squared_error = normal.squared_error;
    const auto& entries = objective.layout().entries;
    const auto parameters = static_cast<Eigen::Index>(theta.size());
    const Eigen::Index basis = a.cols();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(parameters + a.size(), parameters + a.size());
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const auto row = static_cast<Eigen::Index>(entries[e].parameter);
        for (std::size_t f = 0; f < entries.size(); ++f)
            matrix(row, entries[f].parameter) +=
                a.col(entries[e].basis).dot(a.col(entries[f].basis)) *
                normal.entry_entry(static_cast<Eigen::Index>(e), static_cast<Eigen::Index>(f));
        for (Eigen::Index ch = 0; ch < a.rows(); ++ch)
            for (Eigen::Index j = 0; j < basis; ++j) {
                const Eigen::Index column = parameters + ch * basis + j;
                matrix(row, column) +=
                    a(ch, entries[e].basis) * normal.entry_basis(static_cast<Eigen::Index>(e), j);
                matrix(column, row) = matrix(row, column);
            }
    }
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch)
        matrix.block(parameters + ch * basis, parameters + ch * basis, basis, basis) = normal.basis;
    return matrix;
}

// Half the Hessian of the loss by theta and a, from differences of its gradient.
Eigen::MatrixXd half_hessian(Objective& objective, const Space& space, Metric metric,
                             const std::vector<double>& theta, const Coefficients& a,
                             double& squared_error) {
    const auto parameters = static_cast<Eigen::Index>(theta.size());
    const Eigen::Index all = parameters + a.size();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(all, all);
    std::vector<double> by_theta;
    Coefficients by_a;
    squared_error = objective.loss(metric, theta, a, by_theta, by_a);
    const double typical = std::max(a.maxCoeff(), 1e-12);
    for (Eigen::Index i = 0; i < all; ++i) {
        std::vector<double> t = theta;
        Coefficients c = a;
        double& moved = i < parameters ? t[static_cast<std::size_t>(i)] : c.data()[i - parameters];
        const double step =
            1e-3 * std::max(std::abs(moved), i < parameters ? 1e-2 : 1e-2 * typical);
        // Central differences, one-sided ones at the end of a range.
        double ends[2] = {moved - step, moved + step};
        if (i < parameters) {
            const Parameter& p = space.dimensions()[static_cast<std::size_t>(i)].parameter;
            for (double& end : ends)
                end = std::clamp(end, p.lower, p.upper);
        } else {
            ends[0] = std::max(ends[0], 0.0);
        }
        if (!(ends[0] < ends[1]))
            continue; // a fixed parameter
        Eigen::VectorXd gradient[2];
        for (int side = 0; side < 2; ++side) {
            moved = ends[side];
            objective.loss(metric, t, c, by_theta, by_a);
            gradient[side].resize(all);
            gradient[side].head(parameters) =
                Eigen::Map<const Eigen::VectorXd>(by_theta.data(), parameters);
            gradient[side].tail(a.size()) =
                Eigen::Map<const Eigen::VectorXd>(by_a.data(), a.size());
        }
        matrix.col(i) = (gradient[1] - gradient[0]) / (2 * (ends[1] - ends[0]));
    }
    return 0.5 * (matrix + matrix.transpose());
}

// Variances of the parameters `free` from the curvature; NaN for the others and the undetermined.
Eigen::VectorXd variances(const Eigen::MatrixXd& curvature, const std::vector<bool>& free,
                          double residual_variance) {
    std::vector<Eigen::Index> index;
    for (Eigen::Index i = 0; i < curvature.rows(); ++i)
        if (free[static_cast<std::size_t>(i)] && curvature(i, i) > 0)
            index.push_back(i);
    Eigen::VectorXd result =
        Eigen::VectorXd::Constant(curvature.rows(), std::numeric_limits<double>::quiet_NaN());
    const auto n = static_cast<Eigen::Index>(index.size());
    if (n == 0)
        return result;
    Eigen::MatrixXd scaled(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j)
            scaled(i, j) =
                curvature(index[static_cast<std::size_t>(i)], index[static_cast<std::size_t>(j)]) /
                std::sqrt(curvature(index[static_cast<std::size_t>(i)],
                                    index[static_cast<std::size_t>(i)]) *
                          curvature(index[static_cast<std::size_t>(j)],
                                    index[static_cast<std::size_t>(j)]));
    if (!scaled.allFinite())
        return result;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    for (Eigen::Index i = 0; i < n; ++i) {
        double variance = 0;
        for (Eigen::Index k = 0; k < n; ++k) {
            const double component = eigen.eigenvectors()(i, k);
            if (eigen.eigenvalues()[k] > undetermined)
                variance += component * component / eigen.eigenvalues()[k];
            else if (std::abs(component) > 1e-3)
                variance = std::numeric_limits<double>::quiet_NaN();
        }
        const Eigen::Index at = index[static_cast<std::size_t>(i)];
        result[at] = residual_variance * variance / curvature(at, at);
    }
    return result;
}

} // namespace

std::vector<FittedParameter> fitted_parameters(Objective& objective, const Space& space,
                                               Metric metric,
                                               const std::vector<std::string>& channels,
                                               const std::vector<double>& theta,
                                               const Coefficients& a) {
    double squared_error = 0;
    const Eigen::MatrixXd curvature =
        quadratic(metric) ? gauss_newton(objective, theta, a, squared_error)
                          : half_hessian(objective, space, metric, theta, a, squared_error);
    std::vector<FittedParameter> parameters;
    std::vector<bool> free;
    for (std::size_t i = 0; i < theta.size(); ++i) {
        const Space::Dimension& dimension = space.dimensions()[i];
        const bool at_bound = ended_at_bound(dimension, theta[i]);
        parameters.push_back({fmt::format("lobes[{}].{}", dimension.lobe, dimension.parameter.name),
                              theta[i], 0, at_bound});
        free.push_back(!dimension.fixed && !at_bound);
    }
    const double nothing = nothing_share * a.maxCoeff();
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch)
        for (Eigen::Index j = 0; j < a.cols(); ++j) {
            const std::string& channel = channels[static_cast<std::size_t>(ch)];
            parameters.push_back({j == 0 ? fmt::format("kd[{}]", channel)
                                         : fmt::format("lobes[{}].ks[{}]", j - 1, channel),
                                  a(ch, j), 0, a(ch, j) <= nothing});
            free.push_back(a(ch, j) > nothing);
        }
    const double unknowns = static_cast<double>(std::count(free.begin(), free.end(), true));
    const double residuals = objective.samples().norm();
    const double residual_variance = residuals > unknowns
                                         ? squared_error / (residuals - unknowns)
                                         : std::numeric_limits<double>::quiet_NaN();
    const Eigen::VectorXd variance = variances(curvature, free, residual_variance);
    for (std::size_t i = 0; i < parameters.size(); ++i)
        parameters[i].standard_error = std::sqrt(variance[static_cast<Eigen::Index>(i)]);
    return parameters;
}

} // namespace brdfit

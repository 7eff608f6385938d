#include "fit/uncertainty.hpp"

#include "fit/gauss_newton.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

// A parameter this close to the end of its range, as a share of it, ended at a bound.
constexpr double bound_share = 1e-6;
// kd and ks below this share of the largest are 0, as optimisers leave it.
constexpr double nothing_share = 1e-9;

bool ended_at_bound(const Space::Dimension& dimension, double value) {
    const Parameter& p = dimension.parameter;
    const double low = to_scale(p.scale, p.lower), high = to_scale(p.scale, p.upper);
    const double x = to_scale(p.scale, value);
    const double margin = bound_share * (high - low);
    return !dimension.fixed && (x <= low + margin || x >= high - margin);
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
        double step = 1e-3 * std::max(std::abs(moved), i < parameters ? 1e-2 : 1e-2 * typical);
        if (i < parameters &&
            space.dimensions()[static_cast<std::size_t>(i)].parameter.scale == Scale::Angle)
            step = 0.05; // degrees, wherever the frame points
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

// Those among the `free` from `begin` on, as many as the matrix has, that have curvature.
std::vector<Eigen::Index> curved(const Eigen::MatrixXd& curvature, const std::vector<bool>& free,
                                 std::size_t begin) {
    std::vector<Eigen::Index> index;
    for (Eigen::Index i = 0; i < curvature.rows(); ++i)
        if (free[begin + static_cast<std::size_t>(i)] && curvature(i, i) > 0)
            index.push_back(i);
    return index;
}

// The parts of a matrix by rows and columns, divided by the roots of the curvatures they have
// alone.
Eigen::MatrixXd scaled_part(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& rows,
                            const std::vector<Eigen::Index>& columns,
                            const Eigen::MatrixXd& of_rows, const Eigen::MatrixXd& of_columns) {
    Eigen::MatrixXd part(rows.size(), columns.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t j = 0; j < columns.size(); ++j)
            part(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                matrix(rows[i], columns[j]) /
                std::sqrt(of_rows(rows[i], rows[i]) * of_columns(columns[j], columns[j]));
    return part;
}

// The same of all parameters of a quadratic metric. Each channel's kd and ks are eliminated
// (Schur's complement), so that the time grows with the channels, not with their cube.
Eigen::VectorXd variances(const GaussNewton& sums, const std::vector<bool>& free,
                          double residual_variance) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const Eigen::Index parameters = sums.theta.rows(), basis = sums.basis.rows();
    Eigen::VectorXd result = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(free.size()), nan);
    const bool finite = sums.theta.allFinite() && sums.basis.allFinite() &&
                        std::all_of(sums.cross.begin(), sums.cross.end(),
                                    [](const Eigen::MatrixXd& m) { return m.allFinite(); });
    if (!finite)
        return result;
    const std::vector<Eigen::Index> shape = curved(sums.theta, free, 0);
    const auto n = static_cast<Eigen::Index>(shape.size());

    struct Channel {
        std::vector<Eigen::Index> index;
        Eigen::VectorXd variance; ///< with theta fixed; NaN where undetermined
        Eigen::MatrixXd follows;  ///< how kd and ks change with theta, but for the sign
    };
    std::vector<Channel> channels;
    Eigen::MatrixXd reduced = scaled_part(sums.theta, shape, shape, sums.theta, sums.theta);
    for (std::size_t ch = 0; ch < sums.cross.size(); ++ch) {
        const std::size_t begin =
            static_cast<std::size_t>(parameters) + ch * static_cast<std::size_t>(basis);
        Channel channel{curved(sums.basis, free, begin), {}, {}};
        const auto m = static_cast<Eigen::Index>(channel.index.size());
        if (m > 0) {
            const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(
                scaled_part(sums.basis, channel.index, channel.index, sums.basis, sums.basis));
            Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(m, m);
            Eigen::VectorXd unknown = Eigen::VectorXd::Zero(m);
            for (Eigen::Index k = 0; k < m; ++k) {
                const auto v = own.eigenvectors().col(k);
                if (own.eigenvalues()[k] > undetermined)
                    inverse += v * v.transpose() / own.eigenvalues()[k];
                else
                    unknown = (v.array().abs() > 1e-3).select(nan, unknown);
            }
            channel.variance = inverse.diagonal() + unknown;
            const Eigen::MatrixXd cross =
                scaled_part(sums.cross[ch], shape, channel.index, sums.theta, sums.basis);
            channel.follows = inverse * cross.transpose();
            reduced -= cross * channel.follows;
        }
        channels.push_back(std::move(channel));
    }
    Eigen::VectorXd variance = Eigen::VectorXd::Zero(n);
    if (n > 0) {
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(reduced);
        for (Eigen::Index k = 0; k < n; ++k) {
            const Eigen::VectorXd x = eigen.eigenvectors().col(k);
            double square = 1; // of the direction's length, kd and ks included
            for (const Channel& channel : channels)
                square += channel.index.empty() ? 0 : (channel.follows * x).squaredNorm();
            const bool known = eigen.eigenvalues()[k] / square > undetermined;
            const auto add = [&](Eigen::VectorXd& to, const Eigen::VectorXd& direction) {
                for (Eigen::Index i = 0; i < to.size(); ++i)
                    if (known)
                        to[i] += direction[i] * direction[i] / eigen.eigenvalues()[k];
                    else if (std::abs(direction[i]) > 1e-3 * std::sqrt(square))
                        to[i] = nan;
            };
            add(variance, x);
            for (Channel& channel : channels)
                if (!channel.index.empty())
                    add(channel.variance, channel.follows * x);
        }
    }
    for (Eigen::Index i = 0; i < n; ++i) {
        const Eigen::Index at = shape[static_cast<std::size_t>(i)];
        result[at] = residual_variance * variance[i] / sums.theta(at, at);
    }
    for (std::size_t ch = 0; ch < channels.size(); ++ch)
        for (std::size_t j = 0; j < channels[ch].index.size(); ++j) {
            const Eigen::Index at = channels[ch].index[j];
            result[parameters + static_cast<Eigen::Index>(ch) * basis + at] =
                residual_variance * channels[ch].variance[static_cast<Eigen::Index>(j)] /
                sums.basis(at, at);
        }
    return result;
}

} // namespace

std::vector<FittedParameter> fitted_parameters(Objective& objective, const Space& space,
                                               Metric metric,
                                               const std::vector<std::string>& channels,
                                               const std::vector<double>& theta,
                                               const Coefficients& a) {
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
    double squared_error = 0;
    GaussNewton sums;
    Eigen::MatrixXd curvature;
    if (quadratic(metric)) {
        const NormalSums normal = objective.normal_sums(theta, a);
        squared_error = normal.squared_error;
        sums = gauss_newton(normal, objective.layout(), a);
    } else {
        curvature = half_hessian(objective, space, metric, theta, a, squared_error);
    }
    const double unknowns = static_cast<double>(std::count(free.begin(), free.end(), true));
    const double residuals = objective.samples().norm();
    const double residual_variance = residuals > unknowns
                                         ? squared_error / (residuals - unknowns)
                                         : std::numeric_limits<double>::quiet_NaN();
    const Eigen::VectorXd variance = quadratic(metric)
                                         ? variances(sums, free, residual_variance)
                                         : variances(curvature, free, residual_variance);
    for (std::size_t i = 0; i < parameters.size(); ++i)
        parameters[i].standard_error = std::sqrt(variance[static_cast<Eigen::Index>(i)]);
    return parameters;
}

} // namespace brdfit

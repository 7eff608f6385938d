#include "fit/nonnegative.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace brdfit {

namespace {

// Below this share of its length a column is explained by the others as far as float32 sums tell.
constexpr double independent_share = 1e-7;
// A column whose mean square is below this is no column: float32 holds no more digits of it.
constexpr double least_square = 1e-28;

// Solves the rows and columns `free` (a bit mask) of gram x = right by Cholesky decomposition of
// the matrix scaled to a unit diagonal; false where it is singular. x is 0 elsewhere.
bool solve_subset(const SmallMatrix& gram, const SmallVector& right, unsigned free,
                  SmallVector& x) {
    int index[max_unknowns];
    int n = 0;
    for (int i = 0; i < gram.rows(); ++i)
        if ((free >> i & 1U) != 0)
            index[n++] = i;
    double scale[max_unknowns];
    double l[max_unknowns][max_unknowns];
    double z[max_unknowns];
    for (int i = 0; i < n; ++i) {
        const double diagonal = gram(index[i], index[i]);
        if (!(diagonal > least_square))
            return false;
        scale[i] = 1 / std::sqrt(diagonal);
        for (int j = 0; j < i; ++j) {
            double sum = gram(index[i], index[j]) * scale[i] * scale[j];
            for (int k = 0; k < j; ++k)
                sum -= l[i][k] * l[j][k];
            l[i][j] = sum / l[j][j];
        }
        double pivot = 1;
        for (int k = 0; k < i; ++k)
            pivot -= l[i][k] * l[i][k];
        if (!(pivot > independent_share))
            return false;
        l[i][i] = std::sqrt(pivot);
        z[i] = right[index[i]] * scale[i];
        for (int k = 0; k < i; ++k)
            z[i] -= l[i][k] * z[k];
        z[i] /= l[i][i];
    }
    x.setZero();
    for (int i = n - 1; i >= 0; --i) {
        for (int k = i + 1; k < n; ++k)
            z[i] -= l[k][i] * z[k];
        z[i] /= l[i][i];
        x[index[i]] = z[i] * scale[i];
    }
    return true;
}

} // namespace

NonNegativeSolution solve_nonnegative(const SmallMatrix& gram, const SmallVector& projected,
                                      double squared, const SmallVector& reference) {
    const int n = static_cast<int>(gram.rows());
    const unsigned all = (1U << n) - 1;
    NonNegativeSolution best{SmallVector::Zero(n), std::numeric_limits<double>::infinity()};
    SmallVector change(n), right(n), step(n);
    // Larger subsets come first: where all unknowns come out positive nothing can be better.
    for (unsigned free = all;; --free) {
        // Unknowns at their bound change by -reference, which moves the others' right-hand side.
        for (int i = 0; i < n; ++i)
            change[i] = (free >> i & 1U) != 0 ? 0 : -reference[i];
        right.noalias() = projected - gram * change;
        if (solve_subset(gram, right, free, step)) {
            bool feasible = true;
            for (int i = 0; i < n; ++i)
                if ((free >> i & 1U) != 0) {
                    change[i] = step[i];
                    feasible = feasible && reference[i] + step[i] >= 0;
                }
            if (feasible) {
                const double error =
                    squared - 2 * change.dot(projected) + change.dot(gram * change);
                if (error < best.squared_error) {
                    best.squared_error = error;
                    for (int i = 0; i < n; ++i)
                        best.a[i] = (free >> i & 1U) != 0 ? reference[i] + change[i] : 0;
                }
                if (free == all)
                    break;
            }
        }
        if (free == 0)
            break;
    }
    return best;
}

namespace {

// Columns that the others explain are told apart by this much of their square, about the solution
// before: it does not move what is solved, and a few rounds suffice.
constexpr double proximal_share = 1e-7;
constexpr int proximal_rounds = 3, most_active_set_steps = 200;

// Minimises z'Hz/2 - q'z, H positive definite, with rows z >= right, from z, which obeys them. Each
// step solves for the minimum with the rows in `active` as equations; it ends at the next row, or
// drops the row that pulls back most (the primal active-set method; Nocedal and Wright 2006,
// algorithm 16.3). Returns the rows' multipliers.
Eigen::VectorXd minimise_within(const Eigen::MatrixXd& h, const Eigen::VectorXd& q,
                                const Eigen::MatrixXd& rows, const Eigen::VectorXd& right,
                                Eigen::VectorXd& z, std::vector<Eigen::Index>& active) {
    const Eigen::Index n = z.size();
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(rows.rows());
    for (int step = 0; step < most_active_set_steps; ++step) {
        const auto m = static_cast<Eigen::Index>(active.size());
        Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + m, n + m);
        Eigen::VectorXd wanted = Eigen::VectorXd::Zero(n + m);
        system.topLeftCorner(n, n) = h;
        wanted.head(n) = q - h * z;
        for (Eigen::Index i = 0; i < m; ++i) {
            const auto row = rows.row(active[static_cast<std::size_t>(i)]);
            system.block(n + i, 0, 1, n) = row;
            system.block(0, n + i, n, 1) = -row.transpose();
        }
        const Eigen::VectorXd found = system.fullPivLu().solve(wanted);
        const Eigen::VectorXd change = found.head(n);
        multipliers.setZero();
        for (Eigen::Index i = 0; i < m; ++i)
            multipliers[active[static_cast<std::size_t>(i)]] = found[n + i];
        double length = 1;
        Eigen::Index next = -1;
        for (Eigen::Index r = 0; r < rows.rows(); ++r) {
            const double towards = rows.row(r).dot(change);
            if (!(towards < 0) || std::find(active.begin(), active.end(), r) != active.end())
                continue;
            const double until = std::max(0.0, (right[r] - rows.row(r).dot(z)) / towards);
            if (until < length) {
                length = until;
                next = r;
            }
        }
        z += length * change;
        if (next >= 0) {
            active.push_back(next);
            continue;
        }
        Eigen::Index worst = 0;
        if (m == 0 || multipliers.minCoeff(&worst) >= 0)
            break;
        active.erase(std::find(active.begin(), active.end(), worst));
    }
    return multipliers.cwiseMax(0);
}

} // namespace

LimitedSolution solve_limited(const SmallMatrix& gram, const SmallVector& projected, double squared,
                              const SmallVector& reference, const Eigen::MatrixXd& limits) {
    const NonNegativeSolution free = solve_nonnegative(gram, projected, squared, reference);
    LimitedSolution solution{free.a, free.squared_error, Eigen::VectorXd::Zero(limits.rows())};
    const auto obeys = [&] {
        for (Eigen::Index k = 0; k < limits.rows(); ++k) {
            double sum = 0;
            for (Eigen::Index j = 0; j < limits.cols(); ++j)
                if (free.a[j] > 0) // 0 of an infinite one is nothing
                    sum += free.a[j] * limits(k, j);
            if (!(sum <= 1))
                return false;
        }
        return true;
    };
    if (!std::isfinite(free.squared_error) || obeys())
        return solution;

    std::vector<Eigen::Index> used; // unknowns that may be above 0
    for (Eigen::Index j = 0; j < gram.rows(); ++j)
        if (gram(j, j) > least_square && limits.col(j).allFinite())
            used.push_back(j);
    const auto n = static_cast<Eigen::Index>(used.size());
    solution.a.setZero();
    if (n > 0) {
        // In unknowns whose columns have unit length.
        const Eigen::VectorXd scale = gram(used, used).diagonal().cwiseSqrt();
        const Eigen::VectorXd inverse = scale.cwiseInverse();
        Eigen::MatrixXd h = inverse.asDiagonal() * gram(used, used) * inverse.asDiagonal();
        h.diagonal().array() += proximal_share;
        const Eigen::VectorXd all = projected + gram * reference;
        const Eigen::VectorXd pull = inverse.asDiagonal() * all(used);
        Eigen::MatrixXd rows(n + limits.rows(), n);
        rows << Eigen::MatrixXd::Identity(n, n), -limits(Eigen::all, used) * inverse.asDiagonal();
        Eigen::VectorXd right(rows.rows());
        right << Eigen::VectorXd::Zero(n), -Eigen::VectorXd::Ones(limits.rows());
        // From the free solution, scaled down until it obeys.
        Eigen::VectorXd z = scale.asDiagonal() * free.a(used);
        const double largest = -(rows.bottomRows(limits.rows()) * z).minCoeff();
        z /= std::max(1.0, largest);
        std::vector<Eigen::Index> active;
        for (Eigen::Index j = 0; j < n; ++j)
            if (!(z[j] > 0))
                active.push_back(j);
        Eigen::VectorXd multipliers;
        for (int round = 0; round < proximal_rounds; ++round)
            multipliers = minimise_within(h, pull + proximal_share * Eigen::VectorXd(z), rows,
                                          right, z, active);
        for (const Eigen::Index row : active)
            if (row < n)
                z[row] = 0; // but for rounding
        for (Eigen::Index j = 0; j < n; ++j)
            solution.a[used[static_cast<std::size_t>(j)]] = std::max(0.0, z[j] * inverse[j]);
        solution.multipliers = 2 * multipliers.tail(limits.rows());
    }
    const SmallVector change = solution.a - reference;
    solution.squared_error = squared - 2 * change.dot(projected) + change.dot(gram * change);
    return solution;
}

} // namespace brdfit

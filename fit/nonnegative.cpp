#include "fit/nonnegative.hpp"

#include <cmath>
#include <limits>

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

} // namespace brdfit

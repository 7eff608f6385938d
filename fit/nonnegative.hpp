#pragma once

#include <Eigen/Dense>

namespace brdfit {

/// Largest number of unknowns of a non-negative least-squares problem here.
inline constexpr int max_unknowns = 6;

using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_unknowns, max_unknowns>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_unknowns, 1>;

/// The exact non-negative least-squares solution over all subsets of unknowns that may be free.
struct NonNegativeSolution {
    SmallVector a;        ///< >= 0
    double squared_error; ///< at a
};

/// Minimises |y - B a|^2 over a >= 0, given, for the residual r = y - B reference of any reference:
/// the Gram matrix B'B (positive semi-definite), B'r and r'r. Nothing cancels where `reference` is
/// close to the solution. Unknowns that the others explain to float32 precision are kept at 0.
NonNegativeSolution solve_nonnegative(const SmallMatrix& gram, const SmallVector& projected,
                                      double squared, const SmallVector& reference);

/// That solution among those with limits * a <= 1.
struct LimitedSolution {
    SmallVector a;               ///< >= 0
    double squared_error;        ///< at a
    Eigen::VectorXd multipliers; ///< >= 0: the squared error's fall by a row's 1 (Lagrange)
};

/// As solve_nonnegative, with limits * a <= 1 as well; limits: [row][unknown], >= 0, where one is
/// infinite the unknown stays 0.
LimitedSolution solve_limited(const SmallMatrix& gram, const SmallVector& projected, double squared,
                              const SmallVector& reference, const Eigen::MatrixXd& limits);

} // namespace brdfit

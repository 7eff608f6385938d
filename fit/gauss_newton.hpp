#pragma once

#include "fit/objective.hpp"

#include <Eigen/Dense>
#include <vector>

namespace brdfit {

/// J'J of the mean squared error by theta and each channel's kd and ks, J the derivatives of the
/// residuals. Those of different channels do not meet.
struct GaussNewton {
    Eigen::MatrixXd theta;              ///< [parameter][parameter]
    Eigen::MatrixXd basis;              ///< of any channel: [basis][basis]
    std::vector<Eigen::MatrixXd> cross; ///< [channel] theta by basis
};

/// Directions of less curvature than this share of what each parameter has alone are not
/// determined: sums of float32 products tell no less.
inline constexpr double undetermined = 3e-7;

GaussNewton gauss_newton(const NormalSums& sums, const StructureLayout& layout,
                         const Coefficients& a);

/// Half of Gauss-Newton's curvature by theta of the error in which kd and ks follow theta: of each
/// channel those above 0 are eliminated (Schur's complement; Kaufman 1975, A variable projection
/// method for solving separable nonlinear least squares problems). No parameter has less than the
/// undetermined share of what it has alone, so that steps do not follow rounding.
Eigen::MatrixXd projected(const GaussNewton& sums, const Coefficients& a);

} // namespace brdfit

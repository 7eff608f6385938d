#pragma once

#include "fit/minimise.hpp"

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <vector>

namespace brdfit {

/// A sum of squares about a point.
struct Expansion {
    double value;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd curvature; ///< Gauss-Newton's part of the Hessian: positive semi-definite
};

/// A function to minimise that tells its curvature too.
using ExpandedFunction = std::function<Expansion(const std::vector<double>& x)>;

struct DescentOptions {
    int max_evaluations = 300;
    /// Ends where the next step promises less than this share of the value.
    double relative_tolerance = 1e-8;
    /// A value found already: gives up where not even ten times the fall that the next step
    /// promises would lead below.
    double goal = std::numeric_limits<double>::infinity();
};

/// Minimises a sum of squares from `start` within lower <= x <= upper by the Levenberg-Marquardt
/// method.
///
/// A step minimises the quadratic model within the box exactly, by active sets. To Gauss-Newton's
/// curvature comes what steps taken so far tell of the rest of the Hessian (the secant update of
/// Dennis, Gay and Welsch 1981, An adaptive nonlinear least-squares algorithm, section 3): the
/// residuals of a model that does not fit are far from small, and without it steps would only halve
/// the distance. The value never rises; non-finite ones are steps that failed.
Minimum levenberg_marquardt(const ExpandedFunction& function, const std::vector<double>& start,
                            const std::vector<double>& lower, const std::vector<double>& upper,
                            const DescentOptions& options);

} // namespace brdfit

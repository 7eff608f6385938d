#pragma once

#include "fit/objective.hpp"
#include "fit/space.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// A fitted parameter, for reports.
struct FittedParameter {
    std::string name; ///< e.g. "lobes[0].m", "kd[G]"
    double value;
    double standard_error; ///< NaN where it cannot be told: fixed, at a bound, or not determined
    bool at_bound;
};

/// Every parameter of a solution with its standard error, from the curvature of the mean squared
/// error at the optimum: Gauss-Newton's for quadratic metrics, by differences of the gradient for
/// the others. Residuals count as independent, with variances in inverse proportion to their
/// weights.
std::vector<FittedParameter> fitted_parameters(Objective& objective, const Space& space,
                                               Metric metric,
                                               const std::vector<std::string>& channels,
                                               const std::vector<double>& theta,
                                               const Coefficients& a);

} // namespace brdfit

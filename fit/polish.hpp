#pragma once

#include "fit/metric.hpp"
#include "fit/minimise.hpp"
#include "fit/objective.hpp"
#include "fit/space.hpp"

#include <limits>
#include <vector>

namespace brdfit {

/// theta with kd and ks solved for it; `a` may be empty in a start.
struct Solution {
    std::vector<double> theta;
    Coefficients a;
    double squared_error;
};

inline bool better(const Solution& a, const Solution& b) {
    return a.squared_error < b.squared_error;
}

/// Leads starts to local minima of a structure's error. Both must outlive it.
class Polish {
  public:
    Polish(Objective& objective, const Space& space, Metric metric, MinimiseOptions options);

    /// Whether there is a curvature to descend by: metrics that are not quadratic and errors under
    /// a limit on R have none.
    bool can_descend() const { return quadratic(metric_) && !objective_.is_limited(); }
    /// By the Levenberg-Marquardt method, or by NLopt where there is no curvature. May give up
    /// where it will not get below the squared error `goal`.
    Solution descended(const Solution& start,
                       double goal = std::numeric_limits<double>::infinity());
    /// By NLopt, from start.theta and, where the metric is not quadratic, from start.a if there is
    /// one. What descended() found out about its result is not asked for again.
    Solution minimised(const Solution& start);

  private:
    // The result of a descent.
    struct Known {
        Solution solution;
        std::vector<double> x, gradient;
        int evaluations;
    };

    Objective& objective_;
    const Space& space_;
    Metric metric_;
    MinimiseOptions options_;
    std::vector<Known> known_;
};

} // namespace brdfit

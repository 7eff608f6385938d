#pragma once

#include "fit/minimise.hpp"
#include "fit/objective.hpp"
#include "fit/programs.hpp"
#include "fit/search.hpp"
#include "fit/space.hpp"
#include "fit/uncertainty.hpp"
#include "host/measured/samples.hpp"
#include "host/model/material.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

struct FitOptions {
    Metric metric = Metric::Ngan;
    double max_theta = 80;              ///< degrees; samples beyond are dropped
    std::string algorithm = "LD_SLSQP"; ///< as algorithm_named returns it
    int max_evaluations = 500;          ///< of one polish on all samples
    int random_starts = 0;              ///< polished on all samples, besides the global search
    unsigned long seed = 1;             ///< of the random starts and of stochastic algorithms
    std::vector<ParameterRange> ranges; ///< --fix and --bound
    std::optional<Material>
        start; ///< warm start: replaces the global search, unless a lobe has no strength there
};

struct FitResult {
    std::string model; ///< the structure's name
    Material material;
    MetricErrors errors;       ///< from the residuals themselves
    std::vector<double> theta; ///< of all lobes
    std::vector<FittedParameter> parameters;
    std::size_t samples = 0;     ///< used
    std::size_t evaluations = 0; ///< of the objective, on all samples
    std::size_t thinned_evaluations = 0;
    double pass_seconds = 0; ///< in passes over all samples
    std::size_t passes = 0;
    double build_seconds = 0; ///< of programs, from sources or the driver's cache
    double search_seconds = 0, polish_seconds = 0; ///< of the global search and of the polishes
    double seconds = 0;                            ///< all of it
    int random_starts_better = 0; ///< random starts that beat the search by more than 0.1 %
    double samples_per_second() const {
        return pass_seconds > 0 ? static_cast<double>(samples * passes) / pass_seconds : 0;
    }
};

/// Fits structures to one file's samples. The samples must outlive it.
class FileFitter {
  public:
    FileFitter(const Device& device, ProgramCache& programs, const Samples& samples,
               const FitOptions& options);

    /// The global optimum: search, polish, errors and standard errors. Structures that this one
    /// extends are fitted too, once, as they are among its starting points.
    FitResult fit(const Structure& structure);

  private:
    // theta with kd and ks solved for it; `a` may be empty in a start.
    struct Solution {
        std::vector<double> theta;
        Coefficients a;
        double squared_error;
    };
    static bool better(const Solution& a, const Solution& b) {
        return a.squared_error < b.squared_error;
    }
    struct Fitted {
        Space space;
        Solution solution;
        std::size_t thinned_evaluations = 0;
        double build_seconds = 0, search_seconds = 0, polish_seconds = 0;
    };
    // A structure without one of its lobes.
    struct Smaller {
        int missing;
        Structure structure;
    };
    std::vector<Smaller> smaller_than(const Structure& structure) const;
    Solution extended(const Structure& structure, const Space& space, const Smaller& part);
    const Fitted& fitted(const Structure& structure);
    // The objective that polished the structure, or a new one.
    std::unique_ptr<Objective> full_objective(const Structure& structure);
    Objective& thinned_objective(const Structure& structure);
    std::vector<StartingPoint> searched_starts(const Structure& structure, const Space& space);
    std::vector<Solution> drawn_starts(Objective& objective, const Space& space) const;
    std::vector<Solution> polished_thinned(const Structure& structure, const Space& space,
                                           const std::vector<StartingPoint>& starts);
    // The first `count` solutions; those that met in one optimum count as one.
    static std::vector<Solution>
    distinct(const Space& space, const std::vector<Solution>& solutions, std::size_t count);
    // From start.theta and, where the metric is not quadratic, from start.a if there is one.
    Solution polish(Objective& objective, const Space& space, const Solution& start,
                    const MinimiseOptions& options) const;
    MinimiseOptions full_polish() const;
    // Whether every lobe has some strength at a starting point: without it has no slope either.
    bool has_pull(const Structure& structure, const Solution& start);
    std::vector<double> start_theta(const Structure& structure, const Space& space) const;

    const Device& device_;
    ProgramCache& programs_;
    const Samples& samples_;
    FitOptions options_;
    DeviceSamples packed_, thinned_; // thinned_: for the search
    std::map<std::string, std::unique_ptr<Objective>> thinned_objectives_;
    std::map<std::string, Fitted> fitted_;
    // On all samples, from the polish until fit() reports.
    std::map<std::string, std::unique_ptr<Objective>> full_objectives_;
};

} // namespace brdfit

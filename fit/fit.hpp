#pragma once

#include "fit/conserve.hpp"
#include "fit/minimise.hpp"
#include "fit/objective.hpp"
#include "fit/polish.hpp"
#include "fit/programs.hpp"
#include "fit/search.hpp"
#include "fit/space.hpp"
#include "fit/uncertainty.hpp"
#include "host/made_once.hpp"
#include "host/measured/samples.hpp"
#include "host/model/material.hpp"
#include "host/progress.hpp"

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// Of the way from samples to a fit: raised by whatever may let a fit end elsewhere than before, so
/// that results of both ways are not taken for one.
inline constexpr int algorithm_version = 1;

/// How to fit; the defaults find the global optimum of every model.
struct FitOptions {
    /// What is minimised. Ngan's weighs highlights as they look in a rendering; `log` and `cbrt`
    /// give dim regions more say and are several times slower; `l2` is for data whose own density
    /// of samples is the weight wanted.
    Metric metric = Metric::Ngan;
    /// Degrees; samples beyond are dropped. Raise it for data that is good at grazing angles (most
    /// gonioreflectometers lose accuracy there), lower it where the mirror's edge shows.
    double max_theta = 80;
    /// NLopt's for the polish, as algorithm_named returns it. The default one starts where the
    /// Levenberg-Marquardt method ends, the others at the search's results: change it to compare
    /// algorithms. Those without derivatives ("LN_...") need many more evaluations.
    std::string algorithm = "LD_SLSQP";
    /// Of one polish on all samples. Raise it where an algorithm without derivatives, or three
    /// and more lobes, stop at it.
    int max_evaluations = 500;
    /// Led to a local minimum of the thinned samples, besides the global search; from there to one
    /// of all samples, where that may be better than the search's: a check on that.
    /// FitResult::random_starts_better tells what came of it.
    int random_starts = 0;
    /// Of the random starts and of stochastic algorithms. Change it for other starts.
    unsigned long seed = 1;
    /// --fix and --bound: what is known of the material (f0 of a dielectric), or models less
    /// general than the catalogue's (alpha = 0).
    std::vector<ParameterRange> ranges;
    /// Only materials whose directional albedo R is at most 1 + conserved_tolerance in every
    /// channel up to conserved_theta: for renderings in which light is reflected again and again.
    /// The best of them; where the free fit is one, that.
    bool conserve = false;
    /// Warm start for data like what it was fitted to: replaces the global search, unless a lobe
    /// has no strength there. Only a local optimum is promised then.
    std::optional<Material> start;
    /// Asked before each pass over samples, by any thread: whether to give the fit up, which then
    /// throws FitAbandoned.
    std::function<bool()> abandon;
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
    /// Of programs, from sources or the driver's cache, and of first runs of their kernels, which
    /// may compile them. Not in the other times.
    double build_seconds = 0;
    double search_seconds = 0, polish_seconds = 0; ///< of the global search and of the polishes
    double seconds = 0;                            ///< all of it but build_seconds
    int random_starts = 0;                         ///< tried besides the global search
    int random_starts_better = 0; ///< of these, that beat the search by more than 0.1 %
    /// The largest directional albedo R up to 85 degrees, over all channels; of a fit that
    /// conserves energy up to conserved_theta, within conserved_tolerance / 2.
    LargestAlbedo largest_albedo;
    double samples_per_second() const {
        return pass_seconds > 0 ? static_cast<double>(samples * passes) / pass_seconds : 0;
    }
};

class FitQueue; // of fit_all.cpp

/// Fits structures to one file's samples. The samples must outlive it.
class FileFitter {
  public:
    FileFitter(const Device& device, ProgramCache& programs, const Samples& samples,
               const FitOptions& options);
    /// With samples packed for options.metric and options.max_theta.
    FileFitter(const Device& device, ProgramCache& programs, const Samples& samples,
               const FitOptions& options, DeviceSamples packed);
    FileFitter(const FileFitter&) = delete;
    FileFitter& operator=(const FileFitter&) = delete;

    /// The global optimum: search, polish, errors and standard errors. Structures that this one
    /// extends are fitted too, once, as they are among its starting points.
    FitResult fit(const Structure& structure, const ProgressFunction& progress = {});

    /// Makes fits of a queue until none is left for this device, several at once, each on a command
    /// queue of its own.
    void fit_from(FitQueue& queue, std::size_t device);

  private:
    struct Fitted {
        Space space;
        Solution solution;
        std::size_t evaluations = 0, thinned_evaluations = 0, passes = 0;
        double pass_seconds = 0;
        double search_seconds = 0, polish_seconds = 0;
    };
    // The best solution that conserves energy, and the limit that holds it.
    struct Conserving {
        Fitted fitted;
        std::shared_ptr<AlbedoLimit> limit;
    };
    // What fitters of one file share, each of which works for one thread.
    struct Shared {
        DeviceSamples packed, thinned; // thinned: for the search
        MadeOnce<Fitted> fitted;
        MadeOnce<std::shared_ptr<Conserving>> conserving;
    };
    FileFitter(const FileFitter& other, cl::CommandQueue queue);
    // A structure without one of its lobes.
    struct Smaller {
        int missing;
        Structure structure;
    };
    std::vector<Smaller> smaller_than(const Structure& structure) const;
    static Solution extended(const Structure& structure, const Space& space, const Smaller& part,
                             const Solution& known);
    // Builds programs; finds starting points worth a polish on all samples (search, then polish
    // on the thinned samples); polishes them on all samples, and keeps the best.
    const Fitted& fitted(const Structure& structure);
    // The material to start from; null for the parts of its structure, which a search fits.
    const Material* start_of(const Structure& structure) const;
    Fitted fit_freely(const Structure& structure);
    Conserving& conserving(const Structure& structure);
    void make_conserving(const Structure& structure, Conserving& found);
    Solution best_conserving(const Structure& structure, Conserving& found);
    // Adds viewers with R above 1 to the limit and polishes, until there are none; then solves kd
    // and ks for every degree.
    Solution settled(Objective& objective, Conserving& found, Solution solution);
    Space space_of(const Structure& structure) const;
    void build_programs(const Structure& structure);
    std::vector<Solution> finalists(const Structure& structure, const Space& space);
    Solution best_polished(const Structure& structure, const Space& space,
                           const std::vector<Solution>& finalists, bool searched);
    // On all samples; kept until another structure's is asked for.
    Objective& full_objective(const Structure& structure);
    Objective& thinned_objective(const Structure& structure);
    std::vector<StartingPoint> searched_starts(const Structure& structure, const Space& space);
    std::vector<Solution> drawn_starts(Objective& objective, const Space& space) const;
    std::vector<Solution> polished_thinned(const Structure& structure, const Space& space,
                                           const std::vector<StartingPoint>& starts);
    Polish thinned_polish(const Structure& structure, const Space& space);
    // The local minimum that polish leads to, its lobes in order.
    static Solution thinned_minimum(Polish& polish, const Structure& structure, const Space& space,
                                    const Solution& start);
    static std::size_t finalist_count(const Structure& structure);
    // The first `count` solutions; those that met in one optimum count as one.
    static std::vector<Solution>
    distinct(const Space& space, const std::vector<Solution>& solutions, std::size_t count);
    // Whether two solutions are one optimum, found twice.
    static bool alike(const Space& space, const std::vector<double>& a,
                      const std::vector<double>& b);
    Polish full_polish(const Structure& structure, const Space& space);
    // The best local minimum from the starts, by that polish, which may give up where it will not
    // get below the squared error `goal`.
    Solution best_of(Polish& polish, const std::vector<Solution>& starts,
                     double goal = std::numeric_limits<double>::infinity()) const;
    // Improves `solution` by the random starts, and counts in `result` those that beat the fit.
    void try_random_starts(const Structure& structure, const Fitted& fit, Conserving* conserved,
                           Solution& solution, FitResult& result, const ProgressFunction& progress);
    // Whether every lobe has some strength at a starting point: without it has no slope either.
    bool has_pull(const Structure& structure, const Solution& start);
    std::vector<double> theta_of(const Material& start, const Structure& structure,
                                 const Space& space) const;

    const Device device_; // with a queue of its own
    ProgramCache& programs_;
    const Samples& samples_;
    const FitOptions options_;
    const std::shared_ptr<Shared> shared_;
    const DeviceSamples &packed_, &thinned_;
    std::map<std::string, std::unique_ptr<Objective>> thinned_objectives_;
    std::unique_ptr<Objective> full_objective_;
};

} // namespace brdfit

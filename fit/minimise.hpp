#pragma once

#include <functional>
#include <string>
#include <vector>

namespace brdfit {

/// A function to minimise: its value at x and, where `gradient` is given, its derivatives.
using Function = std::function<double(const std::vector<double>& x, std::vector<double>* gradient)>;

/// The NLopt algorithm of that name: NLopt's own ("LD_SLSQP", any case) or without the two letters
/// in front ("slsqp", "bobyqa"). Returns NLopt's own name.
/// Throws UsageError for an unknown name, or one that cannot work on a box.
std::string algorithm_named(const std::string& name);

/// Whether the algorithm, as algorithm_named returns it, draws random numbers.
bool is_stochastic(const std::string& algorithm);

struct MinimiseOptions {
    std::string algorithm = "LD_SLSQP"; ///< as algorithm_named returns it
    int max_evaluations = 300;
    double relative_tolerance = 1e-10; ///< of the value, between iterations
    unsigned long seed = 1;            ///< of stochastic algorithms
    /// Ends after so many evaluations in a row that gained less than least_gain of the value; 0:
    /// never. Line searches that start at an optimum take rounding for slopes.
    int patience = 0;
    static constexpr double least_gain = 1e-7;
};

struct Minimum {
    std::vector<double> x;
    double value; ///< the best finite value seen; infinite where there was none
    int evaluations;
};

/// Minimises from `start` within lower <= x <= upper with NLopt. The best point that the function
/// was ever asked for is returned, whatever NLopt says of its own end: it reports round-off at
/// exact optima, and non-finite values would make some of its algorithms "succeed" with wrong
/// answers, so these are replaced by a large value. An exception from the function stops and comes
/// out of here.
Minimum minimise(const Function& function, const std::vector<double>& start,
                 const std::vector<double>& lower, const std::vector<double>& upper,
                 const MinimiseOptions& options);

} // namespace brdfit

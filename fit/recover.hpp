#pragma once

#include "fit/objective.hpp"
#include "host/microfacet/generator.hpp"
#include "host/progress.hpp"

#include <vector>

namespace brdfit {

struct RecoverOptions {
    double max_theta = 80; ///< degrees; samples beyond are dropped
    int evaluations = 600; ///< of the error, at most, in one descent
    GeneratorOptions generator;
    ProgressFunction progress;
};

/// A distribution of normals that measurements imply, and the material it makes.
struct Recovered {
    MicrofacetTable table;
    double f0 = 0;
    std::vector<double> kd, ks; ///< [channel]; Lambert's diffuse shape
    int evaluations = 0;        ///< of the error
    std::size_t samples = 0;    ///< used
};

/// Recovers a tabulated p(h), over theta_h for isotropic samples, otherwise over theta_h and phi_h.
/// The best distributions of an analytic family (Gaussian to long tails) are found first; from each
/// the logarithm of p is descended by L-BFGS, with the areas g that it implies, kd, ks
/// (non-negative, exact) and f0 (searched) for every p. What is minimised is the squared error of
/// the metric `ngan`, plus a little of its part beyond peak_theta, plus a penalty on how log p
/// leaves the analytic distribution differently at neighbouring nodes: where the data say little, p
/// goes on as that does. The error `ngan` is not above the analytic distribution's. Throws
/// InputError, naming the file, where no sample can be used or nothing is reflected.
Recovered recover(const Device& device, const Generator& generator, const Samples& samples,
                  const RecoverOptions& options);

} // namespace brdfit

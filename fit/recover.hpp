#pragma once

#include "fit/objective.hpp"
#include "host/microfacet/generator.hpp"

#include <vector>

namespace brdfit {

struct RecoverOptions {
    double max_theta = 80; ///< degrees; samples beyond are dropped
    int iterations = 40;   ///< of the alternation, at most
    GeneratorOptions generator;
};

/// A distribution of normals that measurements imply, and the material it makes.
struct Recovered {
    MicrofacetTable table;
    double f0 = 0;
    std::vector<double> kd, ks; ///< [channel]; Lambert's diffuse shape
    int iterations = 0;
    std::size_t samples = 0; ///< used
};

/// Recovers a tabulated p(h), over theta_h for isotropic samples, otherwise over theta_h and phi_h,
/// by alternating between p given the areas g that it implied last (linear least squares on the
/// nodes), g of that p, and kd, ks (non-negative, exact) and f0 (searched), all in the metric
/// `ngan`; an isotropic p is then improved by L-BFGS on its logarithm. Throws InputError, naming
/// the file, where no sample can be used or nothing is reflected.
Recovered recover(const Device& device, const Generator& generator, const Samples& samples,
                  const RecoverOptions& options);

} // namespace brdfit

#pragma once

#include "fit/fit_all.hpp"
#include "fit/programs.hpp"
#include "host/evaluate/synthesise.hpp"
#include "tests/support/models.hpp"
#include "tests/support/support.hpp"

#include <string>
#include <vector>

// What the tests of fits share: materials, their synthesised measurements, and the errors of a fit
// once more in float64.

namespace brdfit::test {

ProgramCache& programs();
/// The default device, to fit on.
FitDevices& fit_devices();

/// Whether a structure's anisotropic form differs from its isotropic one.
bool has_anisotropic_form(const Structure& structure);

/// A material of that structure with `channels` channels and typical parameters, none equal to
/// another, so that each can be told from data.
Material typical_material(const Structure& structure, std::size_t channels = 3);

/// The material measured at random directions, as many as `count`.
Samples measured(const Material& material, std::size_t count, double noise = 0.02,
                 unsigned long seed = 1);

FitResult fit(const Samples& samples, const Structure& structure, const FitOptions& options = {});
FitResult fit(const Samples& samples, const std::string& model, int lobes = 1,
              const FitOptions& options = {});
double error_of(const FitResult& result, Metric metric);

/// Compression of the metrics `log` and `cbrt`, of x = iz f.
double compressed(Metric metric, double x);

/// The errors as objective.hpp defines them, from the reference models.
MetricErrors reference_errors(const Material& material, const Samples& samples,
                              double max_theta = 80);

} // namespace brdfit::test

#pragma once

#include "host/measured/samples.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace brdfit {

/// What a fit minimises; see MetricErrors for the definitions.
enum class Metric { Ngan, L2, Log, Cbrt };
inline constexpr int metric_count = 4;
const char* name_of(Metric metric);
/// The metric of that name. Throws UsageError listing the known names.
Metric metric_named(const std::string& name);
/// Whether the metric is quadratic in kd and ks.
inline bool quadratic(Metric metric) {
    return metric == Metric::Ngan || metric == Metric::L2;
}

/// Errors E = sqrt(sum_k w_k mean_ch (...)^2 / sum_k w_k) of a fit f to the samples y, in the order
/// of Metric: ngan: iz (f - y); l2: the same with w_k = 1; log: ln(1 + iz max(f, 0)) - ln(1 + iz
/// max(y, 0)); cbrt: cbrt(iz f) - cbrt(iz y), each cbrt continued below 1e-6 by the odd cubic that
/// meets it smoothly.
using MetricErrors = std::array<double, metric_count>;

/// The errors for values f of any origin, [channel][sample of
/// the file] as `evaluate` returns them, over the samples `used`.
MetricErrors value_errors(const Samples& samples, const std::vector<std::uint32_t>& used,
                          const std::vector<float>& values);

/// Degrees of theta_h beyond which samples are outside the specular peak, where errors are reported
/// apart.
inline constexpr double peak_theta = 20;

/// The error `ngan` over those of the samples `used` that are outside the specular peak; NaN where
/// there is none.
double error_outside_peak(const Samples& samples, const std::vector<std::uint32_t>& used,
                          const std::vector<float>& values);

} // namespace brdfit

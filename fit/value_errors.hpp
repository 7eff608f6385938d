#pragma once

#include "fit/objective.hpp"

#include <cstdint>
#include <vector>

namespace brdfit {

/// The errors of metric_errors (fit/objective.hpp) for values f of any origin, [channel][sample of
/// the file] as `evaluate` returns them, over the samples `used`.
MetricErrors value_errors(const Samples& samples, const std::vector<std::uint32_t>& used,
                          const std::vector<float>& values);

} // namespace brdfit

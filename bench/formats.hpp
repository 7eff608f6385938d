#pragma once

#include "bench/work.hpp"
#include "host/device/device.hpp"
#include "host/measured/samples.hpp"

#include <vector>

namespace brdfit::bench {

inline constexpr const char *read_work = "read", *rgl_work = "rgl";

/// Reading whole files, written before and in the system's memory: rows in samples a second, one a
/// format, whose name is the row's model. MERL's layout holds `data` (see data_of), the others
/// fewer.
std::vector<Result> measure_reading(const Device& device, const Samples& data);

/// An RGL file of the size that measured ones have, at random pairs of directions in the host's
/// memory, results stored there: a row in pairs a second.
Result measure_rgl(const Device& device, int threads);

} // namespace brdfit::bench

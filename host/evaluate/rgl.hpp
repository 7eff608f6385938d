#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/measured/rgl.hpp"
#include "host/progress.hpp"

#include <vector>

namespace brdfit {

/// The BRDF of an RGL file in 1/sr at each pair of directions, by its warp as the file defines it,
/// [channel][pair]: 0 below the horizon. Beyond the ends of phi_i and theta_i their values hold.
/// Values below 0 are kept.
std::vector<float> evaluate(const Device& device, const RglTables& tables,
                            const Directions& directions, const ProgressFunction& progress = {});

} // namespace brdfit

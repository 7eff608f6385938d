#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/progress.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// A BRDF's values in 1/sr, [channel][pair].
struct Evaluated {
    std::vector<std::string> channels;
    std::vector<float> values;
};

/// A measured file at any directions, as its format defines the values between those that it
/// has: RGL files by their warp. 0 below the horizon. Throws InputError for other formats.
Evaluated evaluate_measured(const Device& device, const std::string& path,
                            const Directions& directions, const ProgressFunction& progress = {});

} // namespace brdfit

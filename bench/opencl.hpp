#pragma once

#include "bench/work.hpp"

#include <vector>

namespace brdfit::bench {

/// The works as the fitter does them: whole evaluations, with the transfers and the solve for kd
/// and ks, on all of the device.
std::vector<Result> measure_device(const Device& device, const Problem& problem,
                                   const Samples& samples);

/// Whether a device's threads can be limited to one: PoCL's, for a process, by the environment
/// variable POCL_MAX_PTHREAD_COUNT.
bool can_run_on_one_thread(const Device& device);

} // namespace brdfit::bench

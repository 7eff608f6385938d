#pragma once

#include "bench/work.hpp"

#include <vector>

namespace brdfit::bench {

/// The works as the fitter does them: whole evaluations, with the transfers and the solve for kd
/// and ks, on all of the device.
std::vector<Result> measure_device(const Device& device, const Problem& problem,
                                   const Samples& samples);

/// Whether a device's threads can be limited to one (PoCL's, for a process).
bool can_run_on_one_thread(const Device& device);

/// Runs this program again with these arguments and PoCL limited to one thread; returns what it
/// wrote to standard output. Throws InputError where it failed.
std::string run_on_one_thread(const std::vector<std::string>& arguments);

} // namespace brdfit::bench

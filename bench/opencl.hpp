#pragma once

#include "bench/problem.hpp"
#include "bench/work.hpp"

#include <vector>

namespace brdfit::bench {

/// The works as the fitter, the evaluator and the sampler do them, with transfers of what is small
/// and the solve for kd and ks, on all of the device; `eval` and `sample` leave their results in
/// its memory. `samples` must outlive the tasks.
std::vector<Task> device_tasks(const Device& device, const Problem& problem,
                               const Samples& samples);

/// What the device does at most, reading buffers of up to `most_bytes`, which should be more than
/// its caches hold.
Peaks measure_peaks(const Device& device, std::size_t most_bytes);

/// Whether a device's threads can be limited to one: PoCL's, for a process, by the environment
/// variable POCL_MAX_PTHREAD_COUNT.
bool can_run_on_one_thread(const Device& device);

} // namespace brdfit::bench

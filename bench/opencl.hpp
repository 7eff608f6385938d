#pragma once

#include "bench/problem.hpp"
#include "bench/work.hpp"

#include <string>
#include <utility>
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

/// The environment in which a process runs a CPU device on one thread: by a sub-device, where the
/// driver has these, otherwise by a variable of its own; empty where there is no way.
std::vector<std::pair<std::string, std::string>> one_thread_environment(const Device& device);

} // namespace brdfit::bench

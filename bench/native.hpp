#pragma once

#include "bench/scalar.hpp"

#include <utility>
#include <vector>

namespace brdfit::bench {

/// Name of the rows of kurt_sums_simd.
inline constexpr const char* simd_baseline = "native openmp simd";

/// Compiler and options of the native baselines.
struct NativeBuild {
    const char *compiler, *scalar_flags, *simd_flags; ///< simd_flags: null where it is not built
};
NativeBuild native_build();

/// `error` and `error-gradient` as plain C++ with OpenMP in float32 planes, on one thread and on
/// all: tasks and their threads. For `kurt` alone; empty for other models and where it is not
/// built. `samples` must outlive the tasks.
std::vector<std::pair<Task, int>> simd_tasks(const Problem& problem,
                                             const std::vector<ScalarSample>& samples);

} // namespace brdfit::bench

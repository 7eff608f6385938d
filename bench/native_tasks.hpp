#pragma once

#include "bench/native/scalar.hpp"
#include "bench/problem.hpp"
#include "bench/work.hpp"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace brdfit::bench {

/// Candidates that scalar_tasks evaluates of a batch: every ... of them.
inline constexpr std::size_t search_candidates = 32, checked_candidates_step = 16;

/// The sampling measured: for a viewer at this angle (radians), of which this many draws are
/// compared.
inline constexpr double viewer_angle = 0.785398163397448;
inline constexpr std::uint64_t sampling_seed = 1;
inline constexpr std::size_t checked_draws = std::size_t{1} << 17;
/// Mean calls a draw.
Calls scalar_draw_calls(const Problem& problem);

/// The works in float64 (scalar_tasks.cpp). `samples` must outlive the tasks.
std::vector<Task> scalar_tasks(const Problem& problem, const std::vector<ScalarSample>& samples);
Task precomputed_task(const Problem& problem, const std::vector<ScalarSample>& samples);

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

#pragma once

#include "bench/work.hpp"

#include <vector>

namespace brdfit::bench {

/// Name of the row all others are compared with.
inline constexpr const char* baseline = "native scalar float64";

/// Compiler and options of the native baselines.
struct NativeBuild {
    const char *compiler, *scalar_flags, *simd_flags; ///< simd_flags: null where it is not built
};
NativeBuild native_build();

/// The works as plain C++, for isotropic `kurt` with one lobe and three channels; empty for other
/// materials.
///   native scalar float64              one thread, half vector and all else from the directions
///   native scalar float64 precomputed  one thread, what depends on directions alone read from
///   memory
std::vector<Result> measure_scalar(const Problem& problem, const Samples& samples);
///   native openmp simd                 the same in float32 planes, on one thread and on all
/// Empty also where it is not built.
std::vector<Result> measure_simd(const Problem& problem, const Samples& samples);

} // namespace brdfit::bench

#pragma once

// The project's model kernels as plain C++ in float64, one sample at a time: OpenCL C that reads
// like its equations is nearly C++. Compiled twice, the second time counting calls of exp and log.
// See bench/native/scalar_models.cmake for the generated list.

#include "bench/native/lazy_log.hpp"
#include "host/directions.hpp" // WI_X and what follows, pi

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>

namespace brdfit::bench {

/// Calls so far of what `counted` counts.
struct CallCounts {
    unsigned long exp = 0, log = 0;
};
inline CallCounts call_counts;

// What OpenCL C has and C++ does not.
inline double sign(double x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}
inline double convert_float(std::uint32_t x) {
    return x;
}
inline bool any_of(bool x) {
    return x;
}
template <typename T, typename Bound>
T clamp(T x, Bound lower, Bound upper) {
    return fmin(fmax(x, T(lower)), T(upper));
}
inline std::uint32_t mul_hi(std::uint32_t a, std::uint32_t b) {
    return static_cast<std::uint32_t>(std::uint64_t{a} * b >> 32);
}

#define V 1
#define ROUGHNESSES 1
#define __global
#define __constant
#define PARAMETER_SPACE
#define PI ::brdfit::pi
#define float double // theta and whatever else is scalar on a device

namespace scalar {
using real = lazy::LazyLog;
using mask = bool;
using uint = std::uint32_t;
using lazy::exp, lazy::log, lazy::log1p, lazy::sqrt, lazy::fmin, lazy::fmax, lazy::fabs;
using std::exp, std::log, std::log1p, std::sqrt, std::fmin, std::fmax, std::fabs; // of theta
// Whatever were not inlined would not know whose logarithm is none. Near the pole, where float32
// needs care, float64 needs none.
#define inline inline __attribute__((always_inline))
#define log_hz log_hz_of_float32
#define LOG_HZ                                                                                     \
    static inline real log_hz(geometry q) {                                                        \
        return log(q.h_z);                                                                         \
    }
#include "scalar_models.inc"
#undef inline
#undef LOG_HZ
} // namespace scalar

namespace counted {
using real = double;
using mask = bool;
using uint = std::uint32_t;
inline double exp(double x) {
    return ++call_counts.exp, std::exp(x);
}
inline double log(double x) {
    return ++call_counts.log, std::log(x);
}
inline double log1p(double x) {
    return ++call_counts.log, std::log1p(x);
}
using std::sqrt, std::fmin, std::fmax, std::fabs, std::rint;
inline double rsqrt(double x) {
    return 1 / std::sqrt(x);
}
#define LOG_HZ
#include "scalar_models.inc"
#undef LOG_HZ
} // namespace counted

#undef V
#undef ROUGHNESSES
#undef __global
#undef __constant
#undef PARAMETER_SPACE
#undef PI
#undef float

} // namespace brdfit::bench

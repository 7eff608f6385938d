#pragma once

// The project's model kernels as plain C++ in float64, one sample at a time: OpenCL C that reads
// like its equations is nearly C++. Compiled twice, the second time counting calls of exp and log.
// See cmake/scalar_models.cmake for the generated list.

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

#define V 1
#define ROUGHNESSES 1
#define __global
#define __constant
#define PI 3.14159265358979323846
#define float double // theta and whatever else is scalar on a device

namespace scalar {
using real = double;
using mask = bool;
using uint = std::uint32_t;
using std::exp, std::log, std::log1p;
inline double rsqrt(double x) {
    return 1 / std::sqrt(x);
}
inline double sign(double x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}
inline double clamp(double x, double low, double high) {
    return std::clamp(x, low, high);
}
inline double convert_float(uint x) {
    return x;
}
inline uint mul_hi(uint a, uint b) {
    return static_cast<uint>(std::uint64_t{a} * b >> 32);
}
#include "scalar_models.inc"
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
using scalar::rsqrt, scalar::sign, scalar::clamp, scalar::convert_float, scalar::mul_hi;
#include "scalar_models.inc"
} // namespace counted

#undef V
#undef ROUGHNESSES
#undef __global
#undef __constant
#undef PI
#undef float

} // namespace brdfit::bench

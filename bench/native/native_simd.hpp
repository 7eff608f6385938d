#pragma once

// Only built-in types: native_simd.cpp is compiled for the machine it is built on, and no inline
// function of a shared header may come from there.

namespace brdfit::bench {

/// With b = {1/pi, g} and r_ch = y_ch - kd_ch / pi - ks_ch g, all weighted: b_j b_k (3) | r_ch b_j,
/// channel by channel (6) | r_ch^2 (1) | for each of f0, m, alpha: d b_0, d b_1, d r_ch (15).
inline constexpr int kurt_sum_count = 25;

/// Samples of isotropic kurt, one array a quantity.
struct KurtPlanes {
    const float *tan2, *log_scale, *log_iz_oz, *p5;
    const float* y[3];
    const float* weight;
    unsigned long count;
};

/// The sums about `strengths` (kd, ks of each channel), the last 15 only with `gradient`.
void kurt_sums_simd(const KurtPlanes& planes, double f0, double m, double alpha,
                    const double* strengths, bool gradient, int threads, double* sums);
/// Threads OpenMP would use.
int simd_threads();

} // namespace brdfit::bench

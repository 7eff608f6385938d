// The sums of native.cpp with every advantage an OpenMP program may have: float32 planes, vectors
// for the machine it is built on (-march=native -ffast-math, so that exp is a vector function too),
// all threads. Float sums over blocks, float64 over the whole, as our kernels do.
#include "bench/native/native_simd.hpp"

#include <cmath>
#include <omp.h>

namespace brdfit::bench {

namespace {

constexpr long block = 2048;

template <bool with_gradient>
void add_block(const KurtPlanes& s, long begin, long end, const float* theta, const float* a,
               double* total) {
    const float f0 = theta[0], inverse = 1 / theta[1], alpha = theta[2];
    const float inverse2 = inverse * inverse;
    const float b = 0.318309886F;
    float sum[kurt_sum_count] = {};
#pragma omp simd reduction(+ : sum[:kurt_sum_count])
    for (long i = begin; i < end; ++i) {
        const float t = s.tan2[i] * inverse2;
        const float shape = std::exp(s.log_scale[i] - alpha * s.log_iz_oz[i] - t) * inverse2;
        const float g = (f0 + (1 - f0) * s.p5[i]) * shape;
        const float w = s.weight[i], wb = w * b, wg = w * g;
        const float r0 = s.y[0][i] - a[0] * b - a[1] * g;
        const float r1 = s.y[1][i] - a[2] * b - a[3] * g;
        const float r2 = s.y[2][i] - a[4] * b - a[5] * g;
        sum[0] += wb * b;
        sum[1] += wg * b;
        sum[2] += wg * g;
        sum[3] += wb * r0;
        sum[4] += wg * r0;
        sum[5] += wb * r1;
        sum[6] += wg * r1;
        sum[7] += wb * r2;
        sum[8] += wg * r2;
        sum[9] += w * (r0 * r0 + r1 * r1 + r2 * r2);
        if (with_gradient) {
            const float by_f0 = w * (1 - s.p5[i]) * shape;
            const float by_m = wg * (2 * inverse) * (t - 1);
            const float by_alpha = -wg * s.log_iz_oz[i];
            sum[10] += by_f0 * b;
            sum[11] += by_f0 * g;
            sum[12] += by_f0 * r0;
            sum[13] += by_f0 * r1;
            sum[14] += by_f0 * r2;
            sum[15] += by_m * b;
            sum[16] += by_m * g;
            sum[17] += by_m * r0;
            sum[18] += by_m * r1;
            sum[19] += by_m * r2;
            sum[20] += by_alpha * b;
            sum[21] += by_alpha * g;
            sum[22] += by_alpha * r0;
            sum[23] += by_alpha * r1;
            sum[24] += by_alpha * r2;
        }
    }
    for (int k = 0; k < kurt_sum_count; ++k)
        total[k] += static_cast<double>(sum[k]);
}

} // namespace

void kurt_sums_simd(const KurtPlanes& planes, double f0, double m, double alpha,
                    const double* strengths, bool gradient, int threads, double* sums) {
    const float theta[] = {static_cast<float>(f0), static_cast<float>(m),
                           static_cast<float>(alpha)};
    float a[6];
    for (int k = 0; k < 6; ++k)
        a[k] = static_cast<float>(strengths[k]);
    double total[kurt_sum_count] = {};
    const long count = static_cast<long>(planes.count);
#pragma omp parallel for schedule(dynamic) num_threads(threads) reduction(+ : total[:kurt_sum_count])
    for (long begin = 0; begin < count; begin += block) {
        const long end = begin + block < count ? begin + block : count;
        if (gradient)
            add_block<true>(planes, begin, end, theta, a, total);
        else
            add_block<false>(planes, begin, end, theta, a, total);
    }
    for (int k = 0; k < kurt_sum_count; ++k)
        sums[k] = total[k];
}

int simd_threads() {
    return omp_get_max_threads();
}

} // namespace brdfit::bench

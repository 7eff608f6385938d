// The compressions phi of the losses that are not quadratic, of x = iz f; *slope = phi'(x), at the
// kink of log that towards x > 0.
inline real compressed_log(real x, real* slope)
{
    const real y = 1.0f + fmax(x, (real)(0.0f));
    *slope = x >= 0.0f ? 1.0f / y : (real)(0.0f);
    return log(y);
}

// cbrt(x), continued below |x| = 1e-6 by the odd cubic that meets it with its slope there.
inline real compressed_cbrt(real x, real* slope)
{
    const float epsilon = 1e-6f;
    const real u = x * (1.0f / epsilon);
    const real magnitude = fmax(fabs(x), (real)(epsilon));
    const real root = exp(log(magnitude) * (1.0f / 3.0f));
    const mask inside = fabs(u) < 1.0f;
    *slope = inside ? (4.0f - 3.0f * u * u) * 3333.3333f : root / (3.0f * magnitude);
    return inside ? u * (4.0f - u * u) * (0.01f / 3.0f) : copysign(root, x);
}

// phi(iz y) of the channels, for log_loss and cbrt_loss; padding becomes 0.
#define DEFINE_COMPRESS(NAME, PHI)                                                                 \
    __kernel void NAME(__global const real* values, __global const real* iz, uint stride,         \
                       __global real* compressed)                                                 \
    {                                                                                              \
        real unused;                                                                               \
        FOR_EACH_OF_RUN(i, stride)                                                                 \
            for (int ch = 0; ch < CHANNELS; ++ch)                                                  \
                compressed[VALUE_AT(stride, i, ch)] =                                               \
                    PHI(iz[i] * values[VALUE_AT(stride, i, ch)], &unused);                          \
    }

DEFINE_COMPRESS(log_compress, compressed_log)
DEFINE_COMPRESS(cbrt_compress, compressed_cbrt)

// Curvatures k of h(x) = (phi(x) - phi(y))^2 / 2, for p = phi(x) and q = phi(y) with slope phi'(x).
// Newton's own, phi'^2 + (p - q) phi'', kept positive; or for `secant` that of the parabola that
// meets h at x and has its minimum at y: it leads far where h is far from a parabola.
#define LEAST_CURVATURE 0.25f
#define MOST_CURVATURE 8.0f

inline real curvature_log(real p, real q, real slope, int secant)
{
    const real share = secant ? (real)(1.0f) : 1.0f - (p - q);
    return slope * slope * clamp(share, (real)(LEAST_CURVATURE), (real)(MOST_CURVATURE));
}

inline real curvature_cbrt(real p, real q, real slope, int secant)
{
    if (secant)
        return slope / fmax(p * p + p * q + q * q, (real)(1e-4f));
    const real share = 2.0f * q / fmax(p, (real)(1e-3f)) - 1.0f;
    return slope * slope * clamp(share, (real)(LEAST_CURVATURE), (real)(MOST_CURVATURE));
}

// For the losses sum over ch of w (phi(iz f) - phi(iz y))^2, what a Newton step in kd and ks needs:
// for each derivative entry half the gradient of the chunk's loss by it, then for each channel
//     loss | half the gradient by each coefficient | w k iz^2 b_j b_l (l <= j): half the Hessian
// `compressed` (phi(iz y)), `solid_angle` (w) and `iz` are planes. Chunks are smaller than those of the other sums; channels
// past the last repeat it.
#define LOSS_CHUNK (CHUNK < 4 ? CHUNK : 4)
#define CHANNEL_SUMS (1 + BASIS + BASIS * (BASIS + 1) / 2)
#define LOSS_SUMS (ENTRIES + LOSS_CHUNK * CHANNEL_SUMS)
#define DEFINE_LOSS(NAME, PHI, CURVATURE)                                                          \
    __kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void NAME(                            \
        __global const real* planes, __global const real* compressed,                             \
        __global const real* solid_angle, __global const real* iz, uint stride,                   \
        PARAMETER_SPACE const float* theta, __global const float* coefficients, __global float* out,  \
        int secant)                                                                                \
    {                                                                                              \
        __local float scratch[LS];                                                                 \
        const uint chunk = get_group_id(1);                                                        \
        const uint begin = get_group_id(0) * BLOCK;                                                \
        real sum[LOSS_SUMS];                                                                       \
        for (int k = 0; k < LOSS_SUMS; ++k)                                                        \
            sum[k] = 0.0f;                                                                         \
        for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {                       \
            real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], pull[BASIS];                         \
            read_planes(planes, stride, i, plane);                                                 \
            material_basis(plane, theta, b, d);                                                    \
            const real w = solid_angle[i];                                                         \
            const real cosine = iz[i];                                                             \
            _Pragma("unroll") for (int j = 0; j < BASIS; ++j) pull[j] = 0.0f;                      \
            int k = ENTRIES;                                                                       \
            _Pragma("unroll") for (int c = 0; c < LOSS_CHUNK; ++c)                                 \
            {                                                                                      \
                const uint ch = min(chunk * LOSS_CHUNK + c, (uint)(CHANNELS - 1));                 \
                __global const float* a = coefficients + ch * BASIS;                             \
                real f = 0.0f, slope;                                                              \
                _Pragma("unroll") for (int j = 0; j < BASIS; ++j) f += a[j] * b[j];                \
                const real q = compressed[VALUE_AT(stride, i, ch)];                                 \
                const real p = PHI(cosine * f, &slope);                                            \
                const real r = p - q;                                                              \
                sum[k++] += w * r * r;                                                             \
                const real wrs = w * r * slope * cosine;                                           \
                const real wk = w * cosine * cosine * CURVATURE(p, q, slope, secant);              \
                _Pragma("unroll") for (int j = 0; j < BASIS; ++j)                                  \
                {                                                                                  \
                    if (chunk * LOSS_CHUNK + c < CHANNELS)                                         \
                        pull[j] += a[j] * wrs;                                                     \
                    sum[k++] += wrs * b[j];                                                        \
                }                                                                                  \
                _Pragma("unroll") for (int j = 0; j < BASIS; ++j)                                  \
                {                                                                                  \
                    const real wb = wk * b[j];                                                     \
                    _Pragma("unroll") for (int l = 0; l <= j; ++l) sum[k++] += wb * b[l];          \
                }                                                                                  \
            }                                                                                      \
            _Pragma("unroll") for (int e = 0; e < ENTRIES; ++e)                                    \
                sum[e] += d[e] * pull[entry_basis[e]];                                             \
        }                                                                                          \
        write_group_sums(sum, LOSS_SUMS, scratch,                                                  \
                         out + (ulong)(chunk * get_num_groups(0) + get_group_id(0)) * LOSS_SUMS);  \
    }

DEFINE_LOSS(log_loss, compressed_log, curvature_log)
DEFINE_LOSS(cbrt_loss, compressed_cbrt, curvature_cbrt)

// Sums over all channels of the squared residuals of every metric, from the residuals themselves:
// ngan w (iz (f - y))^2 | l2 (iz (f - y))^2 | log | cbrt. Padding has w = iz = 0.
#define METRICS 4
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
metric_sums(__global const real* planes, __global const real* values,
            __global const real* solid_angle, __global const real* iz, uint stride,
            PARAMETER_SPACE const float* theta, __global const float* coefficients,
            __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    real sum[METRICS];
    for (int k = 0; k < METRICS; ++k)
        sum[k] = 0.0f;
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], unused;
        read_planes(planes, stride, i, plane);
        material_basis(plane, theta, b, d);
        const real w = solid_angle[i];
        const real cosine = iz[i];
        for (int ch = 0; ch < CHANNELS; ++ch) {
            const real y = values[VALUE_AT(stride, i, ch)];
            real f = 0.0f;
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                f += coefficients[ch * BASIS + j] * b[j];
            const real r = cosine * (f - y);
            const real r_log = compressed_log(cosine * f, &unused) - compressed_log(cosine * y, &unused);
            const real r_cbrt = compressed_cbrt(cosine * f, &unused) - compressed_cbrt(cosine * y, &unused);
            sum[0] += w * r * r;
            sum[1] += r * r;
            sum[2] += w * r_log * r_log;
            sum[3] += w * r_cbrt * r_cbrt;
        }
    }
    write_group_sums(sum, METRICS, scratch, out + (ulong)get_group_id(0) * METRICS);
}

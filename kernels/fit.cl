// The passes over measured samples that fitting needs. After the generated text (see evaluate.cl),
// which also defines
//     CHANNELS     channels of the file
//     CHUNK        channels a sums pass handles at once; values are padded to whole chunks
//     ENTRY_BASIS  {...}: the basis function that each derivative entry belongs to
//     BLOCK        samples a group handles, in units of V
// Samples: planes of the models, values y, weights W = w iz^2; `stride` reals a plane.
// A group writes its sums in float32 (a block is small enough for 1e-6); the host adds the groups in
// order in float64, so that results repeat bit for bit.

// Plane p and channel ch of sample i: on a CPU a sample's planes lie together, and its channels by
// chunks, so that few prefetchers follow few streams; on a GPU neighbouring items read neighbouring samples.
#if LS == 1
#define PLANE_AT(stride, i, p) ((ulong)(i) * PLANES + (p))
#define VALUE_AT(stride, i, ch) (((ulong)((ch) / CHUNK) * (stride) + (i)) * CHUNK + (ch) % CHUNK)
#else
#define PLANE_AT(stride, i, p) ((ulong)(p) * (stride) + (i))
#define VALUE_AT(stride, i, ch) ((ulong)(ch) * (stride) + (i))
#endif

__constant const int entry_basis[ENTRIES + 1] = ENTRY_BASIS;

// Fills the models' planes for the samples that `index` picks from the directions of a file.
__kernel void prepare(__global const float* directions, uint pairs, __global const uint* index,
                      __global real* planes, uint stride)
{
    FOR_EACH_OF_RUN(i, stride)
    {
        real direction[DIRECTION_PLANES];
        for (int lane = 0; lane < V; ++lane) {
            const uint k = index[i * V + lane];
            for (int p = 0; p < DIRECTION_PLANES; ++p)
                ((float*)direction)[p * V + lane] = directions[(ulong)p * pairs + k];
        }
        real plane[PLANES + 1];
        material_prepare(geometry_of(direction), plane);
        for (int p = 0; p < PLANES; ++p)
            planes[PLANE_AT(stride, i, p)] = plane[p];
    }
}

static inline void read_planes(__global const real* planes, uint stride, uint i, real* plane)
{
    for (int p = 0; p < PLANES; ++p)
        plane[p] = planes[PLANE_AT(stride, i, p)];
}

// The sums of variable projection over the extended basis {b_j, derivative entries d_e}, with
// r_ch = y_ch - sum_j coefficients[ch][j] b_j (a nearby solution, so that nothing cancels):
//     W b_j b_k (k <= j) | W r_ch b_j | W r_ch^2 over the chunk's channels
// and where WITH_GRADIENT
//     | W d_e b_j | W d_e r_ch
// and where WITH_NORMAL also | W d_e d_f (f <= e), for Gauss-Newton and standard errors.
// Group (g, chunk) writes at out[(chunk * groups + g) * count].
#define BASIS_SUMS (BASIS * (BASIS + 1) / 2 + CHUNK * BASIS + 1)
#define GRADIENT_SUMS (BASIS_SUMS + ENTRIES * (BASIS + CHUNK))
#define NORMAL_SUMS (GRADIENT_SUMS + ENTRIES * (ENTRIES + 1) / 2)

#define DEFINE_SUMS(NAME, COUNT, WITH_GRADIENT, WITH_NORMAL)                                       \
    __kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void NAME(                            \
        __global const real* planes, __global const real* values, __global const real* weights,   \
        uint stride, PARAMETER_SPACE const float* theta, __global const float* coefficients,         \
        __global float* out)                                                                       \
    {                                                                                              \
        __local float scratch[LS];                                                                 \
        const uint chunk = get_group_id(1);                                                        \
        __global const float* a = coefficients + chunk * CHUNK * BASIS;                          \
        const uint begin = get_group_id(0) * BLOCK;                                                \
        real sum[COUNT];                                                                           \
        _Pragma("unroll") for (int k = 0; k < COUNT; ++k) sum[k] = 0.0f;                           \
        for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {                       \
            real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], r[CHUNK];                            \
            read_planes(planes, stride, i, plane);                                                 \
            const real w = weights[i];                                                             \
            material_basis(plane, theta, b, d);                                                    \
            _Pragma("unroll") for (int ch = 0; ch < CHUNK; ++ch)                                   \
            {                                                                                      \
                r[ch] = values[VALUE_AT(stride, i, chunk * CHUNK + ch)];                           \
                _Pragma("unroll") for (int j = 0; j < BASIS; ++j) r[ch] -= a[ch * BASIS + j] * b[j]; \
            }                                                                                      \
            int k = 0;                                                                             \
            _Pragma("unroll") for (int j = 0; j < BASIS; ++j)                                      \
            {                                                                                      \
                const real wb = w * b[j];                                                          \
                _Pragma("unroll") for (int l = 0; l <= j; ++l) sum[k++] += wb * b[l];              \
            }                                                                                      \
            _Pragma("unroll") for (int ch = 0; ch < CHUNK; ++ch)                                   \
            {                                                                                      \
                const real wr = w * r[ch];                                                         \
                _Pragma("unroll") for (int j = 0; j < BASIS; ++j) sum[k++] += wr * b[j];           \
                sum[BASIS_SUMS - 1] += wr * r[ch];                                                 \
            }                                                                                      \
            k = BASIS_SUMS;                                                                        \
            if (WITH_GRADIENT)                                                                     \
                _Pragma("unroll") for (int e = 0; e < ENTRIES; ++e)                                \
                {                                                                                  \
                    const real wd = w * d[e];                                                      \
                    _Pragma("unroll") for (int j = 0; j < BASIS; ++j) sum[k++] += wd * b[j];       \
                    _Pragma("unroll") for (int ch = 0; ch < CHUNK; ++ch) sum[k++] += wd * r[ch];   \
                }                                                                                  \
            if (WITH_NORMAL)                                                                       \
                _Pragma("unroll") for (int e = 0; e < ENTRIES; ++e)                                \
                {                                                                                  \
                    const real wd = w * d[e];                                                      \
                    _Pragma("unroll") for (int f = 0; f <= e; ++f) sum[k++] += wd * d[f];          \
                }                                                                                  \
        }                                                                                          \
        write_group_sums(sum, COUNT, scratch,                                                      \
                         out + (ulong)(chunk * get_num_groups(0) + get_group_id(0)) * COUNT);      \
    }

DEFINE_SUMS(basis_sums, BASIS_SUMS, 0, 0)
DEFINE_SUMS(gradient_sums, GRADIENT_SUMS, 1, 0)
DEFINE_SUMS(normal_sums, NORMAL_SUMS, 1, 1)

// For solved coefficients: W r_ch^2 over all channels, then for each derivative entry e
// sum over ch of -coefficients[ch][basis of e] W r_ch d_e: half the gradient of the error, in sums
// that do not grow with the channels.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
residual_gradient(__global const real* planes, __global const real* values,
                  __global const real* weights, uint stride, PARAMETER_SPACE const float* theta,
                  __global const float* coefficients, __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    real sum[1 + ENTRIES];
    for (int k = 0; k <= ENTRIES; ++k)
        sum[k] = 0.0f;
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], pull[BASIS];
        read_planes(planes, stride, i, plane);
        material_basis(plane, theta, b, d);
        real squares = 0.0f;
#pragma unroll
        for (int j = 0; j < BASIS; ++j)
            pull[j] = 0.0f;
        for (int ch = 0; ch < CHANNELS; ++ch) {
            real r = values[VALUE_AT(stride, i, ch)];
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                r -= coefficients[ch * BASIS + j] * b[j];
            squares += r * r;
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                pull[j] -= coefficients[ch * BASIS + j] * r;
        }
        const real w = weights[i];
        sum[0] += w * squares;
#pragma unroll
        for (int e = 0; e < ENTRIES; ++e)
            sum[1 + e] += w * d[e] * pull[entry_basis[e]];
    }
    write_group_sums(sum, 1 + ENTRIES, scratch, out + (ulong)get_group_id(0) * (1 + ENTRIES));
}

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

// Rows for the global search, all times sqrt(W): the channels y, then the diffuse shape.
__kernel void fixed_rows(__global const real* planes, __global const real* values,
                         __global const real* weights, uint stride, PARAMETER_SPACE const float* theta,
                         __global real* rows)
{
    FOR_EACH_OF_RUN(i, stride)
    {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1];
        read_planes(planes, stride, i, plane);
        material_basis(plane, theta, b, d);
        const real root = sqrt(weights[i]);
        for (int ch = 0; ch < CHANNELS; ++ch)
            rows[(ulong)ch * stride + i] = root * values[VALUE_AT(stride, i, ch)];
        rows[(ulong)CHANNELS * stride + i] = root * b[0];
    }
}

// Row first + n: the last lobe's shape at candidate n, times sqrt(W). theta: [candidate][parameters]
__kernel void shape_rows(__global const real* planes, __global const real* weights, uint stride,
                         PARAMETER_SPACE const float* theta, int parameters, uint first,
                         __global real* rows)
{
    const uint n = get_global_id(1);
    FOR_EACH_OF_RUN(i, stride)
    {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1];
        read_planes(planes, stride, i, plane);
        material_basis(plane, theta + n * parameters, b, d);
        rows[(ulong)(first + n) * stride + i] = sqrt(weights[i]) * b[BASIS - 1];
    }
}

// For the global search over one lobe: sums of every candidate's shape s = b of the last lobe and, where
// FRESNEL, of its slope t = ds/df0 (s is affine in f0, so that these tell every f0):
//     W s^2 | W s b_0 [| W s t | W t^2 | W t b_0 | W t y_ch] | W s y_ch, y_ch the chunk's channels
// b_0 is the diffuse shape at f0 = 0; theta: [candidate][parameters]. A work-item carries CANDIDATES of
// them at once, so that a sample is read once for all. Group (tile, block, chunk) writes its tile's sums.
#define SHAPE_SUMS (FRESNEL ? 5 + 2 * CHUNK : 2 + CHUNK)
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
shape_sums(__global const real* planes, __global const real* values, __global const real* weights,
           uint stride, PARAMETER_SPACE const float* theta, int parameters, uint count,
           PARAMETER_SPACE const float* diffuse_theta, __global float* out)
{
    __local float scratch[LS];
    const uint first = get_group_id(0) * CANDIDATES;
    const uint begin = get_group_id(1) * BLOCK;
    const uint chunk = get_group_id(2);
    real sum[CANDIDATES * SHAPE_SUMS];
#pragma unroll
    for (int k = 0; k < CANDIDATES * SHAPE_SUMS; ++k)
        sum[k] = 0.0f;
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], wy[CHUNK];
        read_planes(planes, stride, i, plane);
        const real w = weights[i];
#pragma unroll
        for (int ch = 0; ch < CHUNK; ++ch)
            wy[ch] = w * values[VALUE_AT(stride, i, chunk * CHUNK + ch)];
        material_basis(plane, diffuse_theta, b, d);
        const real wb = w * b[0];
#pragma unroll
        for (int c = 0; c < CANDIDATES; ++c) {
            real* const to = sum + c * SHAPE_SUMS;
            material_basis(plane, theta + min(first + c, count - 1) * parameters, b, d);
            const real s = b[BASIS - 1];
            const real ws = w * s;
            to[0] += ws * s;
            to[1] += wb * s;
            int k = 2;
#if FRESNEL
            const real t = d[LAST_LOBE];
            to[2] += ws * t;
            to[3] += w * t * t;
            to[4] += wb * t;
            k = 5;
#pragma unroll
            for (int ch = 0; ch < CHUNK; ++ch)
                to[k++] += wy[ch] * t;
#endif
#pragma unroll
            for (int ch = 0; ch < CHUNK; ++ch)
                to[k++] += wy[ch] * s;
        }
    }
    write_group_sums(sum, CANDIDATES * SHAPE_SUMS, scratch,
                     out + (((ulong)chunk * get_num_groups(1) + get_group_id(1)) * get_num_groups(0) +
                            get_group_id(0)) * (CANDIDATES * SHAPE_SUMS));
}

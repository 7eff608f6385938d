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

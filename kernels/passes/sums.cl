// The sums of variable projection over the extended basis {b_j, derivative entries d_e}, with
// r_ch = y_ch - sum_j coefficients[ch][j] b_j (a nearby solution, so that nothing cancels):
//     W b_j b_k (k <= j) | W r_ch b_j | W r_ch^2 over the chunk's channels
// and where WITH_GRADIENT
//     | W d_e b_j | W d_e r_ch
// and where WITH_NORMAL also | W d_e d_f (f <= e), for Gauss-Newton and standard errors.
// Group (g, chunk) writes at out[(chunk * groups + g) * SUMS].
//
// The host splices this text once for each variant (host/model/program.cpp):
//     NAME            WITH_GRADIENT   WITH_NORMAL
//     basis_sums      0               0
//     gradient_sums   1               0
//     normal_sums     1               1
#if WITH_NORMAL
#define SUMS NORMAL_SUMS(BASIS, CHUNK, ENTRIES)
#elif WITH_GRADIENT
#define SUMS GRADIENT_SUMS(BASIS, CHUNK, ENTRIES)
#else
#define SUMS BASIS_SUMS(BASIS, CHUNK)
#endif

__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
NAME(__global const real* planes, __global const real* values, __global const real* weights, uint stride,
     PARAMETER_SPACE const float* theta, __global const float* coefficients, __global float* out)
{
    __local float scratch[LS];
    const uint chunk = get_group_id(1);
    __global const float* a = coefficients + chunk * CHUNK * BASIS;
    real sum[SUMS];
#pragma unroll
    for (int k = 0; k < SUMS; ++k)
        sum[k] = 0.0f;
    FOR_EACH_OF_BLOCK(i, get_group_id(0), stride)
    {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], r[CHUNK];
        read_planes(planes, stride, i, plane);
        const real w = weights[i];
        material_basis(plane, theta, b, d);
#pragma unroll
        for (int ch = 0; ch < CHUNK; ++ch) {
            r[ch] = values[VALUE_AT(stride, i, chunk * CHUNK + ch)];
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                r[ch] -= a[ch * BASIS + j] * b[j];
        }
        int k = 0;
#pragma unroll
        for (int j = 0; j < BASIS; ++j) {
            const real wb = w * b[j];
#pragma unroll
            for (int l = 0; l <= j; ++l)
                sum[k++] += wb * b[l];
        }
#pragma unroll
        for (int ch = 0; ch < CHUNK; ++ch) {
            const real wr = w * r[ch];
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                sum[k++] += wr * b[j];
            sum[BASIS_SUMS(BASIS, CHUNK) - 1] += wr * r[ch];
        }
        k = BASIS_SUMS(BASIS, CHUNK);
#if WITH_GRADIENT
#pragma unroll
        for (int e = 0; e < ENTRIES; ++e) {
            const real wd = w * d[e];
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                sum[k++] += wd * b[j];
#pragma unroll
            for (int ch = 0; ch < CHUNK; ++ch)
                sum[k++] += wd * r[ch];
        }
#endif
#if WITH_NORMAL
#pragma unroll
        for (int e = 0; e < ENTRIES; ++e) {
            const real wd = w * d[e];
#pragma unroll
            for (int f = 0; f <= e; ++f)
                sum[k++] += wd * d[f];
        }
#endif
    }
    write_group_sums(sum, SUMS, scratch, out + (ulong)(chunk * get_num_groups(0) + get_group_id(0)) * SUMS);
}
#undef SUMS

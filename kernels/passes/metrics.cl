// Sums over all channels of the squared residuals of every metric, from the residuals themselves:
// ngan w (iz (f - y))^2 | l2 (iz (f - y))^2 | log | cbrt. Padding has w = iz = 0.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
metric_sums(__global const real* planes, __global const real* values,
            __global const real* solid_angle, __global const real* iz, uint stride,
            PARAMETER_SPACE const float* theta, __global const float* coefficients,
            __global float* out)
{
    __local float scratch[LS];
    real sum[METRIC_SUMS];
    for (int k = 0; k < METRIC_SUMS; ++k)
        sum[k] = 0.0f;
    FOR_EACH_OF_BLOCK(i, get_group_id(0), stride)
    {
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
            sum[NGAN_SUM] += w * r * r;
            sum[L2_SUM] += r * r;
            sum[LOG_SUM] += w * r_log * r_log;
            sum[CBRT_SUM] += w * r_cbrt * r_cbrt;
        }
    }
    write_group_sums(sum, METRIC_SUMS, scratch, out + (ulong)get_group_id(0) * METRIC_SUMS);
}

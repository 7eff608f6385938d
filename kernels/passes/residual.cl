// For solved coefficients: W r_ch^2 over all channels, then for each derivative entry e
// sum over ch of -coefficients[ch][basis of e] W r_ch d_e: half the gradient of the error, in sums
// that do not grow with the channels.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
residual_gradient(__global const real* planes, __global const real* values,
                  __global const real* weights, uint stride, PARAMETER_SPACE const float* theta,
                  __global const float* coefficients, __global float* out)
{
    __local float scratch[LS];
    real sum[RESIDUAL_SUMS(ENTRIES)];
    for (int k = 0; k < RESIDUAL_SUMS(ENTRIES); ++k)
        sum[k] = 0.0f;
    FOR_EACH_OF_BLOCK(i, get_group_id(0), stride)
    {
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
    write_group_sums(sum, RESIDUAL_SUMS(ENTRIES), scratch,
                     out + (ulong)get_group_id(0) * RESIDUAL_SUMS(ENTRIES));
}

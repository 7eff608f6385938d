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
#define SUMS SHAPE_SUMS(FRESNEL, CHUNK)
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
shape_sums(__global const real* planes, __global const real* values, __global const real* weights,
           uint stride, PARAMETER_SPACE const float* theta, int parameters, uint count,
           PARAMETER_SPACE const float* diffuse_theta, __global float* out)
{
    __local float scratch[LS];
    const uint first = get_group_id(0) * CANDIDATES;
    const uint chunk = get_group_id(2);
    real sum[CANDIDATES * SUMS];
#pragma unroll
    for (int k = 0; k < CANDIDATES * SUMS; ++k)
        sum[k] = 0.0f;
    FOR_EACH_OF_BLOCK(i, get_group_id(1), stride)
    {
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
            real* const to = sum + c * SUMS;
            material_basis(plane, theta + min(first + c, count - 1) * parameters, b, d);
            const real s = b[BASIS - 1];
            const real ws = w * s;
            to[SHAPE_SS] += ws * s;
            to[SHAPE_SB] += wb * s;
            int k = SHAPE_ST;
#if FRESNEL
            const real t = d[LAST_LOBE];
            to[SHAPE_ST] += ws * t;
            to[SHAPE_TT] += w * t * t;
            to[SHAPE_TB] += wb * t;
            k = SHAPE_FIRST_Y;
#pragma unroll
            for (int ch = 0; ch < CHUNK; ++ch)
                to[k++] += wy[ch] * t;
#endif
#pragma unroll
            for (int ch = 0; ch < CHUNK; ++ch)
                to[k++] += wy[ch] * s;
        }
    }
    write_group_sums(sum, CANDIDATES * SUMS, scratch,
                     out + (((ulong)chunk * get_num_groups(1) + get_group_id(1)) * get_num_groups(0) +
                            get_group_id(0)) * (CANDIDATES * SUMS));
}
#undef SUMS

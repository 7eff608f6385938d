// The passes of one loss that is not quadratic, the sum over ch of w (phi(iz f) - phi(iz y))^2, phi and its
// curvature k of compressions.cl. The host splices this text once for each variant
// (host/model/program.cpp):
//     COMPRESS        LOSS        PHI               CURVATURE
//     log_compress    log_loss    compressed_log    curvature_log
//     cbrt_compress   cbrt_loss   compressed_cbrt   curvature_cbrt

// phi(iz y) of the channels; padding becomes 0.
__kernel void COMPRESS(__global const real* values, __global const real* iz, uint stride,
                       __global real* compressed)
{
    real unused;
    FOR_EACH_OF_RUN(i, stride)
        for (int ch = 0; ch < CHANNELS; ++ch)
            compressed[VALUE_AT(stride, i, ch)] = PHI(iz[i] * values[VALUE_AT(stride, i, ch)], &unused);
}

// What a Newton step in kd and ks needs: for each derivative entry half the gradient of the chunk's loss by
// it, then for each channel
//     loss | half the gradient by each coefficient | w k iz^2 b_j b_l (l <= j): half the Hessian
// `compressed` (phi(iz y)), `solid_angle` (w) and `iz` are planes. Chunks are smaller than those of the other
// sums; channels past the last repeat it. Group (g, chunk) writes at out[(chunk * groups + g) * SUMS].
#define LOSS_CHUNK (CHUNK < LARGEST_LOSS_CHUNK ? CHUNK : LARGEST_LOSS_CHUNK)
#define SUMS LOSS_SUMS(BASIS, LOSS_CHUNK, ENTRIES)
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
LOSS(__global const real* planes, __global const real* compressed, __global const real* solid_angle,
     __global const real* iz, uint stride, PARAMETER_SPACE const float* theta,
     __global const float* coefficients, __global float* out, int secant)
{
    __local float scratch[LS];
    const uint chunk = get_group_id(1);
    real sum[SUMS];
    for (int k = 0; k < SUMS; ++k)
        sum[k] = 0.0f;
    FOR_EACH_OF_BLOCK(i, get_group_id(0), stride)
    {
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], pull[BASIS];
        read_planes(planes, stride, i, plane);
        material_basis(plane, theta, b, d);
        const real w = solid_angle[i];
        const real cosine = iz[i];
#pragma unroll
        for (int j = 0; j < BASIS; ++j)
            pull[j] = 0.0f;
        int k = ENTRIES;
#pragma unroll
        for (int c = 0; c < LOSS_CHUNK; ++c) {
            const uint ch = min(chunk * LOSS_CHUNK + c, (uint)(CHANNELS - 1));
            __global const float* a = coefficients + ch * BASIS;
            real f = 0.0f, slope;
#pragma unroll
            for (int j = 0; j < BASIS; ++j)
                f += a[j] * b[j];
            const real q = compressed[VALUE_AT(stride, i, ch)];
            const real p = PHI(cosine * f, &slope);
            const real r = p - q;
            sum[k++] += w * r * r;
            const real wrs = w * r * slope * cosine;
            const real wk = w * cosine * cosine * CURVATURE(p, q, slope, secant);
#pragma unroll
            for (int j = 0; j < BASIS; ++j) {
                if (chunk * LOSS_CHUNK + c < CHANNELS)
                    pull[j] += a[j] * wrs;
                sum[k++] += wrs * b[j];
            }
#pragma unroll
            for (int j = 0; j < BASIS; ++j) {
                const real wb = wk * b[j];
#pragma unroll
                for (int l = 0; l <= j; ++l)
                    sum[k++] += wb * b[l];
            }
        }
#pragma unroll
        for (int e = 0; e < ENTRIES; ++e)
            sum[e] += d[e] * pull[entry_basis[e]];
    }
    write_group_sums(sum, SUMS, scratch, out + (ulong)(chunk * get_num_groups(0) + get_group_id(0)) * SUMS);
}
#undef SUMS
#undef LOSS_CHUNK

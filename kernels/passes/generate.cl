// The microfacet generator (Ashikhmin, Premoze, Shirley 2000): integrals over the distribution of
// normals as sums over nodes h with weights p(h) dw, for many directions at once.

// Nodes of one part: polar angles by rows shares of [LEAST_THETA, greatest_theta], azimuths by psi (see
// kernels/terms/distribution.cl), both with quadrature weights; `rows` a multiple of V, counted in V.
// out: planes h.x, h.y, h.z, p dw at [azimuth][row], from node `first` on of `stride`, all in V.
__kernel void nodes(__global const float* table, int part_number, __global const real* shares,
                    __global const real* share_weights, uint rows, __global const float* psis,
                    __global const float* psi_weights, uint columns, uint first, uint stride,
                    __global real* out)
{
    const uint i = get_global_id(0);
    if (i >= rows * columns)
        return;
    __global const float* part = table + (int)FIRST_PART + part_number * PART_WORDS;
    const float psi = psis[i / rows];
    const float x = STRETCH_X * cos(psi);
    const float y = STRETCH_Y * sin(psi);
    const float r = sqrt(x * x + y * y);
    const float range = greatest_theta(part, x, y) - LEAST_THETA;
    const real theta = LEAST_THETA + range * shares[i % rows];
    const real sine = sin(theta);
    const vector l = {sine * (x / r), sine * (y / r), cos(theta)};
    const vector h = out_of_frame(FRAME, l);
    const real dw = sine * (range * psi_weights[i / rows] / azimuth_slope(part, x, y)) *
                    share_weights[i % rows];
    const real p = part_of_distribution(table, part, h);
    __global real* at = out + first + i;
    at[0] = h.x;
    at[stride] = h.y;
    at[2 * stride] = h.z;
    at[3 * stride] = p * dw;
}

// g(k) = sum of (h.k)+ p dw, Eq. 18: group (b, tile) handles BLOCK nodes and TILE directions k, planes of
// `count` floats, a multiple of TILE, and writes at out[(tile * groups + b) * TILE].
#define TILE 8
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
visible(__global const real* nodes, uint stride, __global const float* directions, uint count,
        __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    const uint tile = get_group_id(1);
    real sum[TILE];
    float x[TILE], y[TILE], z[TILE];
#pragma unroll
    for (int t = 0; t < TILE; ++t) {
        sum[t] = 0.0f;
        x[t] = directions[tile * TILE + t];
        y[t] = directions[count + tile * TILE + t];
        z[t] = directions[2 * count + tile * TILE + t];
    }
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        const real h_x = nodes[i];
        const real h_y = nodes[i + stride];
        const real h_z = nodes[i + 2 * stride];
        const real weight = nodes[i + 3 * stride];
#pragma unroll
        for (int t = 0; t < TILE; ++t)
            sum[t] += weight * fmax(h_x * x[t] + h_y * y[t] + h_z * z[t], (real)(0.0f));
    }
    write_group_sums(sum, TILE, scratch, out + (ulong)(tile * get_num_groups(0) + get_group_id(0)) * TILE);
}

// Reflectances, Eq. 29 as a sum over nodes: wi = 2 c h - wo, dwi = 4 c dw, so that
//     R(wo) = sum of p dw F c iz P(wi, wo) / (iz oz <h.n>)
// Group (b, k) writes four sums at out[(k * groups + b) * 4]: f0 = 0 and 1 with independent, then with
// correlated shadowing. areas: g at the directions; elsewhere it comes from the table.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
reflect(__global const float* table, __global const real* nodes, uint stride,
        __global const float* directions, uint count, __global const float* areas, __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    const uint k = get_group_id(1);
    const vector wo = {(real)(directions[k]), (real)(directions[count + k]),
                       (real)(directions[2 * count + k])};
    const real g_o = areas[k];
    real sum[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        const vector h = {nodes[i], nodes[i + stride], nodes[i + 2 * stride]};
        const geometry q = reflected(wo, h);
        const mask above = q.wi_z > 0.0f && q.c > 0.0f;
        const vector wi = {q.wi_x, q.wi_y, above ? q.wi_z : (real)(1.0f)};
        const real g_i = visible_area_linear(table, wi);
        const real w = nodes[i + 3 * stride] * (above ? q.c * wi.z : (real)(0.0f));
        const real independent = w * shadowing(table, wi, wo, g_i, g_o, false);
        const real correlated = above ? w * shadowing(table, wi, wo, g_i, g_o, true) : (real)(0.0f);
        const real p5 = schlick_p5(q);
        sum[0] += above ? p5 * independent : (real)(0.0f);
        sum[1] += independent;
        sum[2] += above ? p5 * correlated : (real)(0.0f);
        sum[3] += correlated;
    }
    write_group_sums(sum, 4, scratch, out + (ulong)(k * get_num_groups(0) + get_group_id(0)) * 4);
}

// Lambertian facets, Eq. 33: sums of (wi.h)+ (wo.h)+ p dw over pairs of directions, planes of `count`
// floats wi.x .. wo.z; group (b, pair) writes at out[pair * groups + b].
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
facets(__global const real* nodes, uint stride, __global const float* pairs, uint count,
       __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    const uint k = get_group_id(1);
    const float ix = pairs[k], iy = pairs[count + k], iz = pairs[2 * count + k];
    const float ox = pairs[3 * count + k], oy = pairs[4 * count + k], oz = pairs[5 * count + k];
    real sum[1] = {0.0f};
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        const real x = nodes[i];
        const real y = nodes[i + stride];
        const real z = nodes[i + 2 * stride];
        sum[0] += nodes[i + 3 * stride] * fmax(x * ix + y * iy + z * iz, (real)(0.0f)) *
                  fmax(x * ox + y * oy + z * oz, (real)(0.0f));
    }
    write_group_sums(sum, 1, scratch, out + (ulong)k * get_num_groups(0) + get_group_id(0));
}

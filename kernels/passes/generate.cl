// The microfacet generator (Ashikhmin, Premoze, Shirley 2000): integrals over the distribution of
// normals as sums over nodes h with weights p(h) dw, for many directions at once.

// Nodes of one part: polar angles by rows shares of [LEAST_THETA, greatest_theta], azimuths by psi (see
// kernels/terms/distribution.cl), both with quadrature weights; `rows` a multiple of V, counted in V.
// out: the planes of nodes (node_plane) at [azimuth][row], from node `first` on of `stride`, all in V.
__kernel void nodes(__global const float* table, int part_number, __global const real* shares,
                    __global const real* share_weights, uint rows, __global const float* psis,
                    __global const float* psi_weights, uint columns, uint first, uint stride,
                    __global real* out)
{
    const uint i = get_global_id(0);
    if (i >= rows * columns)
        return;
    __global const float* part = table + (int)table[FIRST_PART] + part_number * PART_WORDS;
    const float psi = psis[i / rows];
    const float x = part[STRETCH_X] * cos(psi);
    const float y = part[STRETCH_Y] * sin(psi);
    const float r = sqrt(x * x + y * y);
    const float range = greatest_theta(part, x, y) - part[LEAST_THETA];
    const real theta = part[LEAST_THETA] + range * shares[i % rows];
    const real sine = sin(theta);
    const vector l = {sine * (x / r), sine * (y / r), cos(theta)};
    const vector h = out_of_frame(part + FRAME, l);
    const real dw = sine * (range * psi_weights[i / rows] / azimuth_slope(part, x, y)) *
                    share_weights[i % rows];
    const real p = part_of_distribution(table, part, h);
    __global real* at = out + first + i;
    at[NODE_X * stride] = h.x;
    at[NODE_Y * stride] = h.y;
    at[NODE_Z * stride] = h.z;
    at[NODE_WEIGHT * stride] = p * dw;
}

static inline vector node_at(__global const real* nodes, uint stride, uint i)
{
    const vector h = {nodes[i + NODE_X * stride], nodes[i + NODE_Y * stride], nodes[i + NODE_Z * stride]};
    return h;
}

static inline real node_weight_at(__global const real* nodes, uint stride, uint i)
{
    return nodes[i + NODE_WEIGHT * stride];
}

// A direction of planes of `count` floats.
static inline vector direction_at(__global const float* planes, uint count, uint k)
{
    const vector w = {(real)(planes[k]), (real)(planes[count + k]), (real)(planes[2 * count + k])};
    return w;
}

// g(k) = sum of (h.k)+ p dw, Eq. 18: group (b, tile) handles BLOCK nodes and VISIBLE_TILE directions k,
// planes of `count` floats, a multiple of it, and writes at out[(tile * groups + b) * VISIBLE_TILE].
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
visible(__global const real* nodes, uint stride, __global const float* directions, uint count,
        __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    const uint tile = get_group_id(1);
    real sum[VISIBLE_TILE];
    float x[VISIBLE_TILE], y[VISIBLE_TILE], z[VISIBLE_TILE];
#pragma unroll
    for (int t = 0; t < VISIBLE_TILE; ++t) {
        sum[t] = 0.0f;
        x[t] = directions[tile * VISIBLE_TILE + t];
        y[t] = directions[count + tile * VISIBLE_TILE + t];
        z[t] = directions[2 * count + tile * VISIBLE_TILE + t];
    }
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        const vector h = node_at(nodes, stride, i);
        const real weight = node_weight_at(nodes, stride, i);
#pragma unroll
        for (int t = 0; t < VISIBLE_TILE; ++t)
            sum[t] += weight * fmax(h.x * x[t] + h.y * y[t] + h.z * z[t], (real)(0.0f));
    }
    write_group_sums(sum, VISIBLE_TILE, scratch,
                     out + (ulong)(tile * get_num_groups(0) + get_group_id(0)) * VISIBLE_TILE);
}

// Reflectances, Eq. 29 as a sum over nodes: wi = 2 c h - wo, dwi = 4 c dw, so that
//     R(wo) = sum of p dw F c iz P(wi, wo) / (iz oz <h.n>)
// Group (b, k) writes its sums (reflectance_sum) at out[(k * groups + b) * REFLECTANCE_SUMS]. areas: g at the
// directions; elsewhere it comes from the table.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
reflect(__global const float* table, __global const real* nodes, uint stride,
        __global const float* directions, uint count, __global const float* areas, __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    const uint k = get_group_id(1);
    const vector wo = direction_at(directions, count, k);
    const real g_o = areas[k];
    real sum[REFLECTANCE_SUMS] = {0.0f, 0.0f, 0.0f, 0.0f};
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        const geometry q = reflected(wo, node_at(nodes, stride, i));
        const mask above = q.wi_z > 0.0f && q.c > 0.0f;
        const vector wi = {q.wi_x, q.wi_y, above ? q.wi_z : (real)(1.0f)};
        const real g_i = visible_area_linear(table, wi);
        const real w = node_weight_at(nodes, stride, i) * (above ? q.c * wi.z : (real)(0.0f));
        const real independent = w * shadowing(table, wi, wo, g_i, g_o, false);
        const real correlated = above ? w * shadowing(table, wi, wo, g_i, g_o, true) : (real)(0.0f);
        const real p5 = schlick_p5(q);
        sum[R0] += above ? p5 * independent : (real)(0.0f);
        sum[R1] += independent;
        sum[R0_CORRELATED] += above ? p5 * correlated : (real)(0.0f);
        sum[R1_CORRELATED] += correlated;
    }
    write_group_sums(sum, REFLECTANCE_SUMS, scratch,
                     out + (ulong)(k * get_num_groups(0) + get_group_id(0)) * REFLECTANCE_SUMS);
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
    const vector wi = direction_at(pairs + WI_X * count, count, k);
    const vector wo = direction_at(pairs + WO_X * count, count, k);
    real sum = 0.0f;
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS) {
        const vector h = node_at(nodes, stride, i);
        sum += node_weight_at(nodes, stride, i) * fmax(dot3(h, wi), (real)(0.0f)) *
               fmax(dot3(h, wo), (real)(0.0f));
    }
    write_group_sums(&sum, 1, scratch, out + (ulong)k * get_num_groups(0) + get_group_id(0));
}

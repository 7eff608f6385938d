// An RGL file's BRDF at directions: "An Adaptive Parameterization for Efficient Material Acquisition and
// Rendering", Dupuy and Jakob 2018. Each slice of (phi_i, theta_i) has a density over the unit square of
// half vectors, bilinear between nodes; its conditional distribution along u and its marginal along v take
// (u_h, v_h) to a point of the unit square, where the table has the value. Slices are mixed linearly.
//
// `nodes` holds phi_i, theta_i, ndf and sigma; `warps` for each slice the density in units of a cell's mean
// (its integral over cells of side 1 is 1), its sums along rows up to each node, those over rows.

#define SLICES 4

typedef struct {
    float weight[SLICES];
    int index[SLICES];
    int count;
} slice_mix;

// The interval of ascending nodes that holds x, and how far it lies in it; beyond the ends the end.
static inline int interval_of(__global const float* node, int count, float x, float* part)
{
    *part = 0.0f;
    if (count == 1)
        return 0;
    int low = 0;
    int high = count - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (node[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    *part = clamp((x - node[low]) / (node[low + 1] - node[low]), 0.0f, 1.0f);
    return low;
}

static inline slice_mix slices_at(__global const float* nodes, __constant const int* shape, float phi,
                                  float theta)
{
    float s, t;
    const int p = interval_of(nodes, shape[PHI_NODES], phi, &s);
    const int i = interval_of(nodes + shape[PHI_NODES], shape[THETA_NODES], theta, &t);
    slice_mix mixed;
    mixed.count = 0;
    for (int k = 0; k < SLICES; ++k) {
        const float weight = (k < 2 ? 1.0f - s : s) * (k % 2 == 0 ? 1.0f - t : t);
        mixed.weight[mixed.count] = weight;
        mixed.index[mixed.count] = (p + k / 2) * shape[THETA_NODES] + i + k % 2;
        mixed.count += weight > 0.0f;
    }
    return mixed;
}

// The cell of `nodes` nodes over [0, 1] that holds x, and where in it.
static inline int cell_of(float x, int nodes, float* part)
{
    const float at = clamp(x, 0.0f, 1.0f) * (nodes - 1);
    const int cell = min((int)at, nodes - 2);
    *part = at - cell;
    return cell;
}

static inline float bilinear_at(__global const float* grid, int width, int height, float u, float v)
{
    float s, t;
    const int x = cell_of(u, width, &s);
    const int y = cell_of(v, height, &t);
    __global const float* at = grid + y * width + x;
    return mix(mix(at[0], at[1], s), mix(at[width], at[width + 1], s), t);
}

// The share of the density below v, in y, and along v that below u, in x.
static inline void invert_warp(__global const float* warps, __constant const int* shape,
                               const slice_mix* mixed, float u, float v, float* x, float* y)
{
    const int width = shape[VNDF_WIDTH];
    const int height = shape[VNDF_HEIGHT];
    const ulong plane = (ulong)width * height;
    float s, t;
    const int column = cell_of(u, width, &s);
    const int row = cell_of(v, height, &t);
    float left = 0.0f;
    float right = 0.0f;
    float before = 0.0f;
    float lower_row = 0.0f;
    float upper_row = 0.0f;
    float below = 0.0f;
    for (int k = 0; k < mixed->count; ++k) {
        const float w = mixed->weight[k];
        __global const float* density = warps + (ulong)mixed->index[k] * (2 * plane + height) + row * width;
        __global const float* along = density + plane;
        left += w * mix(density[column], density[column + width], t);
        right += w * mix(density[column + 1], density[column + 1 + width], t);
        before += w * mix(along[column], along[column + width], t);
        lower_row += w * along[width - 1];
        upper_row += w * along[2 * width - 1];
        below += w * along[plane - row * width + row];
    }
    const float whole = mix(lower_row, upper_row, t);
    *x = whole > 0.0f ? (before + s * (left + 0.5f * s * (right - left))) / whole : 0.0f;
    *y = below + t * (lower_row + 0.5f * t * (upper_row - lower_row));
}

// values[channel][i] = f in 1/sr; `count` in units of V.
__kernel void warp(__global const real* directions, uint count, __constant const int* shape,
                   __global const float* nodes, __global const float* warps, __global const float* table,
                   __global float* values)
{
    FOR_EACH_OF_RUN(i, count)
    {
        geometry q = read_geometry(directions, count, i);
        const mask above = q.wi_z > 0.0f && q.wo_z > 0.0f;
        q = above_horizon(q, above);
        if (shape[REDUCTION] > 1) {
            // Into the quadrants that the file has, where y and with four x are negative (-0 too: -pi).
            const real turn_y = q.wi_y > 0.0f ? (real)(-1.0f) : (real)(1.0f);
            const real turn_x = shape[REDUCTION] == 2 ? turn_y
                                : q.wi_x > 0.0f      ? (real)(-1.0f)
                                                     : (real)(1.0f);
            q.wi_x *= turn_x;
            q.wi_y = -fabs(q.wi_y);
            q.h_x *= turn_x;
            q.h_y *= turn_y;
        }
        const real sine = sqrt(q.wi_x * q.wi_x + q.wi_y * q.wi_y);
        const real theta_i = atan2(sine, q.wi_z);
        const real phi_i = atan2(q.wi_y, q.wi_x);
        const real u_h = sqrt(atan2(sqrt(q.h_x * q.h_x + q.h_y * q.h_y), q.h_z) * (2.0f / PI));
        real phi_h = atan2(q.h_y, q.h_x);
        if (shape[ISOTROPIC]) {
            const real turned = atan2(q.wi_x * q.h_y - q.wi_y * q.h_x, q.wi_x * q.h_x + q.wi_y * q.h_y);
            phi_h = sine > 0.0f ? turned : phi_h;
        }
        const real v_h = (phi_h + PI) * (0.5f / PI);
        const real u_i = sqrt(theta_i * (2.0f / PI));
        const real v_i = (phi_i + PI) * (0.5f / PI);
        __global const float* ndf = nodes + shape[PHI_NODES] + shape[THETA_NODES];
        __global const float* sigma = ndf + shape[NDF_WIDTH] * shape[NDF_HEIGHT];
        const int width = shape[TABLE_WIDTH];
        const int height = shape[TABLE_HEIGHT];
        const int channels = shape[CHANNELS];
        for (int lane = 0; lane < V; ++lane) {
            const float u = ((const float*)&u_h)[lane];
            const float v = ((const float*)&v_h)[lane];
            const slice_mix mixed = slices_at(nodes, shape, ((const float*)&phi_i)[lane],
                                              ((const float*)&theta_i)[lane]);
            float x, y, s, t;
            invert_warp(warps, shape, &mixed, u, v, &x, &y);
            float factor = 1.0f / ((const float*)&q.wo_z)[lane];
            if (shape[JACOBIAN])
                factor *= bilinear_at(ndf, shape[NDF_WIDTH], shape[NDF_HEIGHT], u, v) /
                          (4.0f * bilinear_at(sigma, shape[SIGMA_WIDTH], shape[SIGMA_HEIGHT],
                                              ((const float*)&u_i)[lane], ((const float*)&v_i)[lane]));
            if (!((const int*)&above)[lane])
                factor = 0.0f;
            const int column = cell_of(x, width, &s);
            const int row = cell_of(y, height, &t);
            for (int ch = 0; ch < channels; ++ch) {
                float value = 0.0f;
                for (int k = 0; k < mixed.count; ++k) {
                    __global const float* at =
                        table + ((ulong)mixed.index[k] * channels + ch) * width * height + row * width + column;
                    value += mixed.weight[k] * mix(mix(at[0], at[1], s), mix(at[width], at[width + 1], s), t);
                }
                values[((ulong)ch * count + i) * V + lane] = clamp(factor * value, -FLT_MAX, FLT_MAX);
            }
        }
    }
}

// Draws of a whole material, and their density. After the generated text (see
// host/model/program.cpp) that also defines
//     component_sample(j, wo, theta, u1, u2)    wi of component j: 0 diffuse, 1.. lobes
//     component_densities(q, theta, p)          p[j], its density
// A component is drawn with probability P_j proportional to its albedo at wo, averaged over channels:
// strengths[j], its mean coefficient, times the albedo of b_j in a table.

// table[j][i][k]: wo of height max((i / (HEIGHTS-1))^2, LEAST_HEIGHT) and azimuth k / (AZIMUTHS-1) SECTOR.
// The table only has to resemble the albedo; the other quadrants are taken as mirror images, those of
// TURNED lobes as turned by half a circle.
#ifdef TURNED
#define SECTOR PI
#else
#define SECTOR (0.5f * PI)
#endif
#define LEAST_HEIGHT 1e-4f
#define TABLE_SAMPLES 128

// Fills the table, an entry a work-item, by drawing from each component alone.
__kernel void tabulate(PARAMETER_SPACE const float* theta, __global float* table)
{
    const uint entry = get_global_id(0);
    if (entry >= BASIS * HEIGHTS * AZIMUTHS)
        return;
    const int j = entry / (HEIGHTS * AZIMUTHS);
    const float root = (float)(entry / AZIMUTHS % HEIGHTS) / (HEIGHTS - 1);
    const float z = fmax(root * root, LEAST_HEIGHT);
    const float phi = (float)(entry % AZIMUTHS) / (AZIMUTHS - 1) * SECTOR;
    const float r = sqrt((1.0f - z) * (1.0f + z));
    const vector wo = {(real)(r * cos(phi)), (real)(r * sin(phi)), (real)(z)};
    float sum = 0.0f;
    for (uint i = 0; i < TABLE_SAMPLES / V; ++i) {
        const ureal index = i * V + lane_numbers();
        geometry q = component_sample(j, wo, theta, unit_interval(sobol_0(index, 1u)),
                                      unit_interval(sobol_1(index, 2u)));
        const mask above = q.wi_z > 0.0f;
        q = above_horizon(q, above);
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], p[BASIS];
        material_prepare(q, plane);
        material_basis(plane, theta, b, d);
        component_densities(q, theta, p);
        sum += lanes_sum(above && p[j] > 0.0f ? fmin(b[j] * q.wi_z / p[j], (real)(1e6f)) : (real)(0.0f));
    }
    table[entry] = sum / TABLE_SAMPLES;
}

// P_j at wo; diffuse for a black material.
static inline void probabilities(__global const float* table, __global const float* strengths, float x,
                                 float y, float z, float* p)
{
    const float height = sqrt(clamp(z, 0.0f, 1.0f)) * (HEIGHTS - 1);
#ifdef TURNED
    const float azimuth = atan2(fabs(y), y < 0.0f ? -x : x) * ((AZIMUTHS - 1) / SECTOR);
#else
    const float azimuth = atan2(fabs(y), fabs(x)) * ((AZIMUTHS - 1) * 2.0f / PI);
#endif
    const int i = min((int)height, HEIGHTS - 2);
    const int k = min((int)azimuth, AZIMUTHS - 2);
    const float s = height - i;
    const float t = azimuth - k;
    float sum = 0.0f;
    for (int j = 0; j < BASIS; ++j) {
        __global const float* at = table + (j * HEIGHTS + i) * AZIMUTHS + k;
        p[j] = strengths[j] * mix(mix(at[0], at[1], t), mix(at[AZIMUTHS], at[AZIMUTHS + 1], t), s);
        sum += p[j];
    }
    for (int j = 0; j < BASIS; ++j)
        p[j] = sum > 0.0f ? p[j] / sum : (j == 0 ? 1.0f : 0.0f);
}

// Sample number first + i for every i below V * count:
// the planes wi, pdf and, a channel each, the weight f iz / pdf (drawn_plane); the latter two 0 below the
// horizon.
// keys: the seed (Philox), or the three dimensions' scrambles (Sobol).
__kernel void sample(float4 wo_, uint4 keys, int sobol, uint first, uint count,
                     PARAMETER_SPACE const float* theta, __global const float* table,
                     __global const float* strengths, __global const float* coefficients, int channels,
                     __global real* out)
{
    float probability[BASIS];
    probabilities(table, strengths, wo_.x, wo_.y, wo_.z, probability);
    const vector wo = {(real)(wo_.x), (real)(wo_.y), (real)(wo_.z)};
    FOR_EACH_OF_RUN(i, count)
    {
        const ureal index = first + i * V + lane_numbers();
        ureal x[4] = {index, 0u, 0u, 0u};
        if (sobol) {
            x[0] = sobol_0(index, keys.x);
            x[1] = sobol_1(index, keys.y);
            x[2] = sobol_2(index, keys.z);
        } else
            philox(x, keys.x, keys.y);
        const real u1 = unit_interval(x[0]);
        const real u2 = unit_interval(x[1]);
        const real choice = unit_interval(x[2]);

        geometry q;
        float passed = 0.0f;
        bool drawn = false;
#pragma unroll
        for (int j = 0; j < BASIS; ++j) {
            if (probability[j] > 0.0f) {
                const geometry other = component_sample(j, wo, theta, u1, u2);
                q = drawn ? selected(choice > passed, other, q) : other;
                drawn = true;
            }
            passed += probability[j];
        }

        const vector wi = wi_of(q);
        const mask above = q.wi_z > 0.0f && q.wo_z > 0.0f;
        q = above_horizon(q, above);
        real p[BASIS], plane[PLANES + 1], b[BASIS], d[ENTRIES + 1];
        component_densities(q, theta, p);
        real pdf = 0.0f;
        for (int j = 0; j < BASIS; ++j)
            pdf += probability[j] * fmin(p[j], (real)(FLT_MAX));
        pdf = finite_above(pdf, above);
        out[i + DRAWN_WI_X * (ulong)count] = wi.x;
        out[i + DRAWN_WI_Y * (ulong)count] = wi.y;
        out[i + DRAWN_WI_Z * (ulong)count] = wi.z;
        out[i + DRAWN_PDF * (ulong)count] = pdf;
        material_prepare(q, plane);
        material_basis(plane, theta, b, d);
        const real scale = pdf > 0.0f ? q.wi_z / pdf : (real)(0.0f);
        for (int ch = 0; ch < channels; ++ch) {
            real f = 0.0f;
            for (int j = 0; j < BASIS; ++j)
                f += coefficients[ch * BASIS + j] * fmin(b[j], (real)(FLT_MAX));
            out[i + (DRAWN_WEIGHTS + ch) * (ulong)count] =
                finite_above(fmin(f, (real)(FLT_MAX)) * scale, above);
        }
    }
}

// out[i]: density of wi given wo; 0 below the horizon.
__kernel void density(__global const real* directions, uint count, PARAMETER_SPACE const float* theta,
                      __global const float* table, __global const float* strengths, __global real* out)
{
    FOR_EACH_OF_RUN(i, count)
    {
        geometry q = read_geometry(directions, count, i);
        const mask above = q.wi_z > 0.0f && q.wo_z > 0.0f;
        q = above_horizon(q, above);
        real probability[BASIS], p[BASIS];
        for (int lane = 0; lane < V; ++lane) {
            float one[BASIS];
            probabilities(table, strengths, ((float*)&q.wo_x)[lane], ((float*)&q.wo_y)[lane],
                          ((float*)&q.wo_z)[lane], one);
            for (int j = 0; j < BASIS; ++j)
                ((float*)&probability[j])[lane] = one[j];
        }
        component_densities(q, theta, p);
        real pdf = 0.0f;
        for (int j = 0; j < BASIS; ++j)
            pdf += probability[j] * fmin(p[j], (real)(FLT_MAX));
        out[i] = finite_above(pdf, above);
    }
}

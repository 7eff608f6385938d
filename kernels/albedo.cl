// Directional albedos of one component: the integral of b_j iz over wi, for many directions wo and
// parameters at once. After the generated text (see host/device/program.cpp) that also defines
//     component_sample(j, wo, theta, u1, u2)    wi of component j: 0 diffuse, 1.. lobes
//     component_densities(q, theta, p)          p[j], its density
// A task is an integral: tasks[t] = component j, strategy + 4 power, first and number of its samples;
// wo[t] = direction, and in w an index of refraction or 0; thetas[t * PARAMETERS..] its parameters.

#define OWN 0          // the component's own sampler alone
#define OWN_SHARED 1   // own sampler, weighed against the horizon's
#define HORIZON 2      // the horizon's sampler, weighed against the component's own
#define CLIPPED 3      // own sampler, with u1 from above where wi meets the horizon

// iz = u1^power at a uniform azimuth. Weighed against this, a component that grows towards the
// horizon less than iz^(1 / power - 1) vanishes there.
static inline geometry horizon_sample(vector wo, float power, real u1, real u2)
{
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    const real z = exp(power * log(u1));
    const real r = sqrt((1.0f - z) * (1.0f + z));
    const vector wi = {r * cosine, r * sine, z};
    return between(wi, wo);
}

static inline real horizon_density(geometry q, float power)
{
    return (0.5f / PI / power) * exp((1.0f / power - 1.0f) * log(q.wi_z));
}

// The u1 above which wi is above the horizon (see kernels/sampling.cl), to float32's resolution.
static inline real rising(int j, vector wo, __constant const float* theta, real u2)
{
    real lower = 0.0f;
    real upper = 1.0f;
    for (int k = 0; k < 24; ++k) {
        const real middle = 0.5f * (lower + upper);
        const mask above = component_sample(j, wo, theta, middle, u2).wi_z > 0.0f;
        upper = above ? middle : upper;
        lower = above ? lower : middle;
    }
    return upper;
}

// Fresnel's reflectance of unpolarised light at a dielectric, 1 where it reflects totally.
static inline real dielectric(real c, float ior)
{
    const real g2 = ior * ior - 1.0f + c * c;
    const real g = sqrt(fmax(g2, (real)(0.0f)));
    const real a = (g - c) / (g + c);
    const real b = (c * (g + c) - 1.0f) / (c * (g - c) + 1.0f);
    return g2 > 0.0f ? 0.5f * a * a * (1.0f + b * b) : (real)(1.0f);
}

// Sums over a group's samples of the weights b_j iz / p, and of those times (1 - c)^5 or, where an
// index of refraction is given, times Fresnel's reflectance: out[(t * groups + g) * 2 + 0, 1].
// Group g handles replicate g % replicates, whose two scrambles are keys[replicate], and part
// g / replicates of the task's samples; all are multiples of V.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void albedo(
    __global const float4* wo_, __global const uint4* tasks, __constant const float* thetas,
    __global const uint2* keys, uint replicates, uint part, __global float* out)
{
    __local float scratch[LS];
    const uint t = get_group_id(1);
    const uint group = get_group_id(0);
    const uint4 task = tasks[t];
    const int j = task.x;
    const uint strategy = task.y % 4;
    const float power = task.y / 4;
    const uint2 key = keys[group % replicates];
    const uint begin = group / replicates * part;
    const uint end = min(begin + part, task.w);
    __constant const float* theta = thetas + t * PARAMETERS;
    const float4 w = wo_[t];
    const vector wo = {(real)(w.x), (real)(w.y), (real)(w.z)};
    real sum[2] = {0.0f, 0.0f};
    for (uint i = begin + get_local_id(0) * V; i < end; i += LS * V) {
        const ureal index = task.z + i + lane_numbers();
        real u1 = unit_interval(sobol_0(index, key.x));
        const real u2 = unit_interval(sobol_1(index, key.y));
        real share = 1.0f;
        if (strategy == CLIPPED) {
            const real from = rising(j, wo, theta, u2);
            share -= from;
            u1 = from + share * u1;
        }
        geometry q = strategy == HORIZON ? horizon_sample(wo, power, u1, u2)
                                         : component_sample(j, wo, theta, u1, u2);
        const mask above = q.wi_z > 0.0f && q.c > 0.0f;
        q = above_horizon(q, above);
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], p[BASIS];
        material_prepare(q, plane);
        material_basis(plane, theta, b, d);
        component_densities(q, theta, p);
        const real density = fmin(p[j], (real)(FLT_MAX)) +
                             (power == 0.0f ? (real)(0.0f) : horizon_density(q, power));
        const real weight = above && density > 0.0f
                                ? fmin(share * fmin(b[j], (real)(FLT_MAX)) * (q.wi_z / density), (real)(1e30f))
                                : (real)(0.0f);
        sum[0] += weight;
        sum[1] += weight * (w.w > 0.0f ? dielectric(q.c, w.w) : schlick_p5(q));
    }
    write_group_sums(sum, 2, scratch, out + ((ulong)t * get_num_groups(0) + group) * 2);
}

// How a component behaves at the horizon: the largest b_j iz over azimuths of wi, at iz = NEAR and at
// iz = NEARER, into out[2t] and out[2t + 1]. One work-item a task.
#define NEAR 1e-12f
#define NEARER 1e-18f
#define HORIZON_AZIMUTHS 64

static inline float horizon_value(int j, vector wo, __constant const float* theta, float z)
{
    float largest = 0.0f;
    for (uint i = 0; i < HORIZON_AZIMUTHS; i += V) {
        real turns;
        for (int lane = 0; lane < V; ++lane)
            ((float*)&turns)[lane] = (i + lane + 0.5f) / HORIZON_AZIMUTHS;
        real cosine;
        const real sine = sine_of_turns(turns, &cosine);
        const vector wi = {cosine, sine, (real)(z)};
        const geometry q = between(wi, wo);
        real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1];
        material_prepare(q, plane);
        material_basis(plane, theta, b, d);
        for (int lane = 0; lane < V; ++lane)
            largest = fmax(largest, ((float*)&b[j])[lane] * z);
    }
    return largest;
}

__kernel void horizon(__global const float4* wo_, __global const uint4* tasks,
                      __constant const float* thetas, uint count, __global float* out)
{
    const uint t = get_global_id(0);
    if (t >= count)
        return;
    const float4 w = wo_[t];
    const vector wo = {(real)(w.x), (real)(w.y), (real)(w.z)};
    out[2 * t] = horizon_value(tasks[t].x, wo, thetas + t * PARAMETERS, NEAR);
    out[2 * t + 1] = horizon_value(tasks[t].x, wo, thetas + t * PARAMETERS, NEARER);
}

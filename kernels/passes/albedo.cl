// Directional albedos of one component: the integral of b_j iz over wi, for many directions wo and
// parameters at once. After the generated text (see host/model/program.cpp) that also defines
//     component_sample(j, wo, theta, u1, u2)    wi of component j: 0 diffuse, 1.. lobes
//     component_densities(q, theta, p)          p[j], its density
// A task is an integral: tasks[t] = component j, strategy + STRATEGIES power (albedo.h), first and number
// of its samples; wo[t] = direction, and in w an index of refraction or 0; thetas[t * PARAMETERS..] its
// parameters.

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

// A u1 a little above the one from which wi is above the horizon (see terms/half_vectors.cl), 0 where it
// always is. Searched in -log(u1), in which the slopes of half vectors are smooth, by secants that keep
// the root between them and, every fourth step, a half.
static inline real rising(int j, vector wo, PARAMETER_SPACE const float* theta, real u2)
{
    real above = 0.0f;
    real below = 16.5f;
    real z_above = wo.z;
    real z_below = component_sample(j, wo, theta, exp(-below), u2).wi_z;
    const mask crosses = z_below <= 0.0f;
    mask was_up = z_below > 1.0f; // no
    for (int k = 1; k < 32; ++k) {
        const real secant = (above * z_below - below * z_above) / (z_below - z_above);
        const mask halve = (mask)(k % 4 == 0) || !(secant > above) || !(secant < below);
        const real at = halve ? 0.5f * (above + below) : secant;
        const real z = component_sample(j, wo, theta, exp(-at), u2).wi_z;
        const mask up = z > 0.0f;
        // Illinois: an end that stays twice counts half.
        z_above = up ? z : (k > 1 && !was_up ? 0.5f * z_above : z_above);
        z_below = up ? (was_up ? 0.5f * z_below : z_below) : z;
        was_up = up;
        above = up ? at : above;
        below = up ? below : at;
        if (!any_of(crosses && below - above > 2e-6f * (1.0f + above)))
            break;
    }
    return crosses ? exp(-above) : (real)(0.0f);
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
// index of refraction is given, times Fresnel's reflectance: out[(t * groups + g) * ALBEDO_SUMS..].
// Group g handles replicate g % replicates, whose two scrambles are keys[replicate], and part
// g / replicates of the task's samples; all are multiples of V.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void albedo(
    __global const float4* wo_, __global const uint4* tasks, PARAMETER_SPACE const float* thetas,
    __global const uint2* keys, uint replicates, uint part, __global float* out)
{
    __local float scratch[LS];
    const uint t = get_group_id(1);
    const uint group = get_group_id(0);
    const uint4 task = tasks[t];
    const int j = task.x;
    const uint strategy = task.y % STRATEGIES;
    const float power = task.y / STRATEGIES;
    const int steps = strategy == CLIPPED ? STEPS : 1;
    const uint2 key = keys[group % replicates];
    const uint begin = group / replicates * part;
    const uint end = min(begin + part, task.w);
    PARAMETER_SPACE const float* theta = thetas + t * PARAMETERS;
    const float4 w = wo_[t];
    const vector wo = {(real)(w.x), (real)(w.y), (real)(w.z)};
    real sum[ALBEDO_SUMS] = {0.0f, 0.0f};
    for (uint i = begin + get_local_id(0) * V; i < end; i += LS * V) {
        const ureal index = task.z + i + lane_numbers();
        const real u2 = unit_interval(sobol_1(index, key.y));
        real u1 = unit_interval(sobol_0(index, key.x));
        const real from = strategy == CLIPPED ? rising(j, wo, theta, u2) : (real)(0.0f);
        for (int step = 0; step < steps; ++step) {
            // More points go to the ends, where the tails of lobes are: u = 3 u1^2 - 2 u1^3.
            const real warped = strategy < OWN_SHARED ? u1 * u1 * (3.0f - 2.0f * u1) : u1;
            const real slope = strategy < OWN_SHARED ? 6.0f * u1 * (1.0f - u1) : (real)(1.0f);
            const real u = from + (1.0f - from) * warped;
            const real share = slope * (1.0f - from) / steps;
            geometry q = strategy == HORIZON ? horizon_sample(wo, power, u, u2)
                                             : component_sample(j, wo, theta, u, u2);
            const mask above = q.wi_z > 0.0f && q.c > 0.0f;
            q = above_horizon(q, above);
            real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1], p[BASIS];
            material_prepare(q, plane);
            material_basis(plane, theta, b, d);
            component_densities(q, theta, p);
            const real density = fmin(p[j], (real)(FLT_MAX)) +
                                 (power == 0.0f ? (real)(0.0f) : horizon_density(q, power));
            const real f = share * fmin(b[j], (real)(FLT_MAX)) * (q.wi_z / density);
            const real weight = above && density > 0.0f ? fmin(f, (real)(1e30f)) : (real)(0.0f);
            sum[ALBEDO_ALL] += weight;
            sum[ALBEDO_WEIGHTED] += weight * (w.w > 0.0f ? dielectric(q.c, w.w) : schlick_p5(q));
            u1 += 1.0f / STEPS;
            u1 -= u1 < 1.0f ? (real)(0.0f) : (real)(1.0f);
        }
    }
    write_group_sums(sum, ALBEDO_SUMS, scratch, out + ((ulong)t * get_num_groups(0) + group) * ALBEDO_SUMS);
}

// How a component behaves at the horizon: the largest b_j iz over azimuths of wi, at iz = NEAR and at
// iz = NEARER, into out[t * HORIZON_VALUES..]. One work-item a task.
#define HORIZON_AZIMUTHS 64

// The azimuths lie closer and closer to the one opposite to wo, where sharp lobes are: half vectors turn
// fast there.
static inline float horizon_value(int j, vector wo, PARAMETER_SPACE const float* theta, float z)
{
    const real r2 = wo.x * wo.x + wo.y * wo.y;
    const mask tilted = r2 > 0.0f;
    const real x = tilted ? -wo.x * rsqrt(r2) : (real)(1.0f);
    const real y = tilted ? -wo.y * rsqrt(r2) : (real)(0.0f);
    float largest = 0.0f;
    for (uint i = 0; i < HORIZON_AZIMUTHS; i += V) {
        real turns;
        for (int lane = 0; lane < V; ++lane) {
            const float t = (i + lane + 0.5f) * (2.0f / HORIZON_AZIMUTHS) - 1.0f;
            const float t2 = t * t;
            ((float*)&turns)[lane] = 0.5f * t * t2 * t2;
        }
        real cosine;
        const real sine = sine_of_turns(fabs(turns), &cosine) * sign(turns);
        const vector wi = {x * cosine - y * sine, x * sine + y * cosine, (real)(z)};
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
                      PARAMETER_SPACE const float* thetas, uint count, __global float* out)
{
    const uint t = get_global_id(0);
    if (t >= count)
        return;
    const float4 w = wo_[t];
    const vector wo = {(real)(w.x), (real)(w.y), (real)(w.z)};
    out[t * HORIZON_VALUES + VALUE_NEAR] =
        horizon_value(tasks[t].x, wo, thetas + t * PARAMETERS, NEAR);
    out[t * HORIZON_VALUES + VALUE_NEARER] =
        horizon_value(tasks[t].x, wo, thetas + t * PARAMETERS, NEARER);
}

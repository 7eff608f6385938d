// What the models' samplers share. NAME_sample(wo, theta, u1, u2) draws wi for wo from two uniform
// numbers in (0, 1); NAME_density(q, theta) is its density by the solid angle of wi. theta has the
// anisotropic form. wi may come out below the horizon: such a sample is worth nothing, and the density
// integrates to less than 1 over the hemisphere by just that loss. Where the model does not vanish at
// the horizon, u1 is the number that lifts wi: for given wo and u2, wi is above the horizon for all u1
// beyond some number, so that albedos can be integrated up to the horizon and no further.

typedef struct {
    real x, y, z;
} vector;

static inline real dot3(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline vector scaled(vector a, real s)
{
    const vector b = {a.x * s, a.y * s, a.z * s};
    return b;
}

static inline vector unit(vector a) { return scaled(a, 1.0f / sqrt(dot3(a, a))); }

static inline vector wi_of(geometry q)
{
    const vector wi = {q.wi_x, q.wi_y, q.wi_z};
    return wi;
}

static inline vector wo_of(geometry q)
{
    const vector wo = {q.wo_x, q.wo_y, q.wo_z};
    return wo;
}

static inline vector h_of(geometry q)
{
    const vector h = {q.h_x, q.h_y, q.h_z};
    return h;
}

// wi and wo of planes that begin with directions (write_directions).
static inline vector wi_at(const real* plane)
{
    const vector wi = {plane[WI_X], plane[WI_Y], plane[WI_Z]};
    return wi;
}

static inline vector wo_at(const real* plane)
{
    const vector wo = {plane[WO_X], plane[WO_Y], plane[WO_Z]};
    return wo;
}

static inline geometry geometry_from(vector wi, vector wo, vector h, real c)
{
    const geometry q = {wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, h.x, h.y, h.z, c};
    return q;
}

// wi = 2 (wo.h) h - wo. The half vector is kept as it was drawn: wi + wo tells it less exactly. For
// wo.h <= 0 wi is below the horizon.
static inline geometry reflected(vector wo, vector h)
{
    const real c = dot3(wo, h);
    const vector wi = {2.0f * c * h.x - wo.x, 2.0f * c * h.y - wo.y, 2.0f * c * h.z - wo.z};
    return geometry_from(wi, wo, h, c);
}

static inline geometry between(vector wi, vector wo)
{
    const vector sum = {wi.x + wo.x, wi.y + wo.y, wi.z + wo.z};
    const real length = fmax(sqrt(dot3(sum, sum)), (real)(1e-18f));
    return geometry_from(wi, wo, scaled(sum, 1.0f / length), 0.5f * length);
}

static inline geometry selected(mask first, geometry a, geometry b)
{
    const geometry q = {
        first ? a.wi_x : b.wi_x, first ? a.wi_y : b.wi_y, first ? a.wi_z : b.wi_z,
        first ? a.wo_x : b.wo_x, first ? a.wo_y : b.wo_y, first ? a.wo_z : b.wo_z,
        first ? a.h_x : b.h_x,   first ? a.h_y : b.h_y,   first ? a.h_z : b.h_z,
        first ? a.c : b.c,
    };
    return q;
}

// sin(2 pi u) and, in *cosine, cos(2 pi u), for u in [0, 1].
static inline real sine_of_turns(real u, real* cosine)
{
    const real quarter = rint(4.0f * u);
    const real x = (2.0f * PI) * (u - 0.25f * quarter); // within pi / 4
    const real x2 = x * x;
    const real s =
        x * (1.0f - x2 * (1.0f / 6 - x2 * (1.0f / 120 - x2 * (1.0f / 5040 - x2 / 362880.0f))));
    const real c = 1.0f - x2 * (0.5f - x2 * (1.0f / 24 - x2 * (1.0f / 720 - x2 / 40320.0f)));
    const mask odd = quarter == 1.0f || quarter == 3.0f;
    const real a = odd ? c : s;
    const real b = odd ? s : c;
    *cosine = quarter == 1.0f || quarter == 2.0f ? -b : b;
    return quarter == 2.0f || quarter == 3.0f ? -a : a;
}

// 1 - exp(-x) for x >= 0 without cancellation.
static inline real one_minus_exp(real x)
{
    const real small = x * (1.0f - x * (0.5f - x * (1.0f / 6 - x * (1.0f / 24 - x * (1.0f / 120)))));
    return x < 0.1f ? small : 1.0f - exp(-x);
}

// Half vector of slopes (x, y).
static inline vector half_of_slopes(real x, real y)
{
    const real z = 1.0f / sqrt(1.0f + x * x + y * y);
    const vector h = {x * z, y * z, z};
    return h;
}

// Kurt et al. 2010, Eq. 16-17: tan^2 theta_h = -log(u1) / (cos^2 phi/mx^2 + sin^2 phi/my^2),
// phi = atan2(my sin(2 pi u2), mx cos(2 pi u2)). So the slopes of h are sqrt(-log u1) times
// (mx cos(2 pi u2), my sin(2 pi u2)).
static inline geometry beckmann_sample(vector wo, float mx, float my, real u1, real u2)
{
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    const real r = sqrt(-log(u1));
    return reflected(wo, half_of_slopes(mx * r * cosine, my * r * sine));
}

// Its density, Eq. 20: D hz / (4 c) = exp(-t) / (4 pi mx my hz^3 c).
static inline real beckmann_density(geometry q, float mx, float my)
{
    const real t = squared(q.h_x / q.h_z / mx) + squared(q.h_y / q.h_z / my);
    return exp(-t - 3.0f * log_hz(q) - log(q.c)) * (0.25f / PI / mx / my);
}

// NAME_sample and NAME_density of a model whose half vectors come from D hz of roughnesses MX, MY.
#define SAMPLES_BECKMANN(NAME, MX, MY)                                                             \
    static inline geometry NAME##_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2) \
    {                                                                                              \
        return beckmann_sample(wo, MX, MY, u1, u2);                                                \
    }                                                                                              \
    static inline real NAME##_density(geometry q, PARAMETER_SPACE const float* theta)                   \
    {                                                                                              \
        return beckmann_density(q, MX, MY);                                                        \
    }

// Half vector of azimuth (cosine, sine), not normalised, and log(hz) <= 0.
static inline vector half_of_log(real cosine, real sine, real log_z)
{
    const real r = sqrt(one_minus_exp(-2.0f * log_z) / (cosine * cosine + sine * sine));
    const vector h = {r * cosine, r * sine, exp(log_z)};
    return h;
}

// nx cos^2 phi_h + ny sin^2 phi_h; any azimuth will do at the pole.
static inline real exponent_at(real x, real y, float nx, float ny)
{
    const real x2 = x * x;
    const real y2 = y * y;
    const real r2 = x2 + y2;
    return r2 < 1e-30f ? (real)(nx) : (nx * x2 + ny * y2) / r2;
}

// The cosine's density iz / pi: for diffuse shapes.
static inline geometry cosine_sample(vector wo, real u1, real u2)
{
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    const real r = sqrt(u1);
    const vector wi = {r * cosine, r * sine, sqrt(1.0f - u1)};
    return between(wi, wo);
}

static inline real cosine_density(geometry q) { return q.wi_z * (1.0f / PI); }

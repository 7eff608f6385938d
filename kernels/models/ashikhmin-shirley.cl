// Ashikhmin, Shirley 2000, Eq. 4:
//     g = sqrt((nu + 1)(nv + 1)) / (8 pi) hz^e F / (c max(iz, oz)),
//     e = (nu h.x^2 + nv h.y^2) / (1 - hz^2)
// computed, as in terms/cosine_power.cl, as
//     F sqrt((nu + 1)(nv + 1)) exp(k + e log(hz)),   k = -log(8 pi c max(iz, oz))
// theta: f0, n or nu nv

enum { ASHIKHMIN_SHIRLEY_PLANES = COSINE_POWER_PLANES };

static inline void ashikhmin_shirley_prepare(geometry q, real* plane)
{
    cosine_power_prepare(q, 1.0f, -log(8.0f * PI * q.c * fmax(q.wi_z, q.wo_z)), plane);
}

static inline real ashikhmin_shirley(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    return cosine_power_lobe(plane, theta, d);
}

// Half vectors by Eq. 9 and 10, hz = (1 - u2)^(1/(e+1)).
static inline geometry ashikhmin_shirley_sample(vector wo, PARAMETER_SPACE const float* theta, real u1,
                                                real u2)
{
    return reflected(wo, cosine_power_half(theta[1], theta[2], 1.0f, u1, 1.0f - u2));
}

// Eq. 6 and 8: p = sqrt((nu+1)(nv+1)) / (2 pi) hz^e / (4 c).
static inline real ashikhmin_shirley_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float nu = theta[1];
    const float nv = theta[2];
    const real e = exponent_at(q.h_x, q.h_y, nu, nv);
    return sqrt((nu + 1.0f) * (nv + 1.0f)) * (0.125f / PI) * exp(e * log_hz(q) - log(q.c));
}

static inline real ashikhmin_shirley_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    return cosine_power_by_turn(q, 1.0f, theta[1], theta[2]);
}

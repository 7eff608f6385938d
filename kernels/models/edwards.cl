// The energy-conserving half-vector family of Kurt et al. 2010, Eq. 8 (Edwards et al. 2006), from the
// half-vector disk by orthogonal projection:
//     g = F p(h) / (4 c iz),
//     p(h) = hz sqrt((nx+1)(ny+1)) / pi (hz^2)^e,   e = nx cos^2 phi_h + ny sin^2 phi_h
// computed, as in terms/cosine_power.cl, as
//     F sqrt((nx+1)(ny+1)) exp(k + 2 e log(hz)),   k = log(hz) - log(4 pi c) - log(iz)
// theta: f0, n or nx ny

enum { EDWARDS_PLANES = COSINE_POWER_PLANES };

static inline void edwards_prepare(geometry q, real* plane)
{
    cosine_power_prepare(q, 2.0f, log_hz(q) - log(4.0f * PI * q.c) - log(q.wi_z), plane);
}

static inline real edwards(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    return cosine_power_lobe(plane, theta, d);
}

// Half vectors from p(h), hz^2 = u1^(1/(e+1)).
static inline geometry edwards_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    return reflected(wo, cosine_power_half(theta[1], theta[2], 2.0f, u2, u1));
}

// p(h) / (4 c).
static inline real edwards_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float nx = theta[1];
    const float ny = theta[2];
    const real e = exponent_at(q.h_x, q.h_y, nx, ny);
    return sqrt((nx + 1.0f) * (ny + 1.0f)) * (0.25f / PI) *
           exp((2.0f * e + 1.0f) * log_hz(q) - log(q.c));
}

static inline real edwards_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    return cosine_power_by_turn(q, 2.0f, theta[1], theta[2]);
}

// The energy-conserving half-vector family of Kurt et al. 2010, Eq. 8 (Edwards et al. 2006), from the
// half-vector disk by orthogonal projection:
//     g = F p(h) / (4 c iz),   p(h) = hz sqrt((nx+1)(ny+1)) / pi (hz^2)^(nx cos^2 phi_h + ny sin^2 phi_h)
// theta: f0, n or nx ny

static inline void edwards_prepare(geometry q, real* plane)
{
    cosine_power_prepare(q, 2.0f, plane);
    plane[ROUGHNESSES] = log_hz(q) - log(4.0f * PI * q.c) - log(q.wi_z);
    plane[ROUGHNESSES + 1] = schlick_p5(q);
}

static inline real edwards(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real s = cosine_power(plane, plane[ROUGHNESSES], theta + 1, d + 1);
    const real g = schlick_times(plane[ROUGHNESSES + 1], theta[0], s, d);
    scale_by(g, d + 1);
    return g;
}

// Half vectors from p(h), hz^2 = u1^(1/(e+1)).
static inline geometry edwards_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    return reflected(wo, cosine_power_half(theta[1], theta[2], 2.0f, u2, u1));
}

static inline real edwards_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float nx = theta[1];
    const float ny = theta[2];
    const real e = exponent_at(q.h_x, q.h_y, nx, ny);
    return sqrt((nx + 1.0f) * (ny + 1.0f)) * (0.25f / PI) *
           exp((2.0f * e + 1.0f) * log_hz(q) - log(q.c));
}

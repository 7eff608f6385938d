// The energy-conserving half-vector family of Kurt et al. 2010, Eq. 8 (Edwards et al. 2006), from the
// half-vector disk by orthogonal projection:
//     g = F p(h) / (4 c iz),   p(h) = hz sqrt((nx+1)(ny+1)) / pi (hz^2)^(nx cos^2 phi_h + ny sin^2 phi_h)
// theta: f0, n or nx ny

static inline void edwards_prepare(geometry q, real* plane)
{
    const real log_z = log_hz(q);
#if ROUGHNESSES == 1
    plane[0] = 2.0f * log_z;
#else
    // log(hz^2) / (1 - hz^2) tends to -1 at the pole.
    const real s = q.h_x * q.h_x + q.h_y * q.h_y;
    const real ratio = s < 1e-30f ? (real)(-1.0f) : 2.0f * log_z / s;
    plane[0] = q.h_x * q.h_x * ratio;
    plane[1] = q.h_y * q.h_y * ratio;
#endif
    plane[ROUGHNESSES] = log_z - log(4.0f * PI * q.c) - log(q.wi_z);
    plane[ROUGHNESSES + 1] = schlick_p5(q);
}

static inline real edwards(const real* plane, __constant const float* theta, real* d)
{
    const real p5 = plane[ROUGHNESSES + 1];
#if ROUGHNESSES == 1
    const float n = theta[1];
    const real s = (n + 1.0f) * exp(plane[1] + n * plane[0]);
    const real g = schlick(p5, theta[0]) * s;
    d[1] = g * (plane[0] + 1.0f / (n + 1.0f));
#else
    const float nx = theta[1];
    const float ny = theta[2];
    const real s = sqrt((nx + 1.0f) * (ny + 1.0f)) * exp(plane[2] + nx * plane[0] + ny * plane[1]);
    const real g = schlick(p5, theta[0]) * s;
    d[1] = g * (plane[0] + 0.5f / (nx + 1.0f));
    d[2] = g * (plane[1] + 0.5f / (ny + 1.0f));
#endif
    d[0] = (1.0f - p5) * s;
    return g;
}

// Half vectors from p(h): tan phi = sqrt((nx+1)/(ny+1)) tan(2 pi u1) through all quadrants,
// hz^2 = u2^(1/(nx cos^2 phi + ny sin^2 phi + 1)).
static inline geometry edwards_sample(vector wo, __constant const float* theta, real u1, real u2)
{
    const float nx = theta[1];
    const float ny = theta[2];
    real cosine;
    real sine = sine_of_turns(u1, &cosine);
    cosine *= sqrt(ny + 1.0f);
    sine *= sqrt(nx + 1.0f);
    const real e = exponent_at(cosine, sine, nx, ny);
    return reflected(wo, half_of_log(cosine, sine, 0.5f * log(u2) / (e + 1.0f)));
}

static inline real edwards_density(geometry q, __constant const float* theta)
{
    const float nx = theta[1];
    const float ny = theta[2];
    const real e = exponent_at(q.h_x, q.h_y, nx, ny);
    return sqrt((nx + 1.0f) * (ny + 1.0f)) * (0.25f / PI) *
           exp((2.0f * e + 1.0f) * log_hz(q) - log(q.c));
}

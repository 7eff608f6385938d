// Ashikhmin, Shirley 2000, Eq. 4:
//     g = sqrt((nu + 1)(nv + 1)) / (8 pi) hz^e F / (c max(iz, oz)),
//     e = (nu h.x^2 + nv h.y^2) / (1 - hz^2)
// theta: f0, n or nu nv

static inline void ashikhmin_shirley_prepare(geometry q, real* plane)
{
#if ROUGHNESSES == 1
    plane[0] = log_hz(q);
#else
    // log(hz) / (1 - hz^2) tends to -1/2 at the pole.
    const real s = q.h_x * q.h_x + q.h_y * q.h_y;
    const real ratio = s < 1e-30f ? (real)(-0.5f) : log_hz(q) / s;
    plane[0] = q.h_x * q.h_x * ratio;
    plane[1] = q.h_y * q.h_y * ratio;
#endif
    plane[ROUGHNESSES] = -log(8.0f * PI * q.c * fmax(q.wi_z, q.wo_z));
    plane[ROUGHNESSES + 1] = schlick_p5(q);
}

static inline real ashikhmin_shirley(const real* plane, __constant const float* theta, real* d)
{
    const real p5 = plane[ROUGHNESSES + 1];
#if ROUGHNESSES == 1
    const float n = theta[1];
    const real s = (n + 1.0f) * exp(plane[1] + n * plane[0]);
    const real g = schlick(p5, theta[0]) * s;
    d[1] = g * (plane[0] + 1.0f / (n + 1.0f));
#else
    const float nu = theta[1];
    const float nv = theta[2];
    const real s = sqrt((nu + 1.0f) * (nv + 1.0f)) * exp(plane[2] + nu * plane[0] + nv * plane[1]);
    const real g = schlick(p5, theta[0]) * s;
    d[1] = g * (plane[0] + 0.5f / (nu + 1.0f));
    d[2] = g * (plane[1] + 0.5f / (nv + 1.0f));
#endif
    d[0] = (1.0f - p5) * s;
    return g;
}

// Half vectors by Eq. 9 and 10: tan phi = sqrt((nu+1)/(nv+1)) tan(pi/2 u1) in a quadrant, carried on
// through all four, so that equal parts of u1 are stratified over the azimuth;
// hz = (1 - u2)^(1/(nu cos^2 phi + nv sin^2 phi + 1)).
static inline geometry ashikhmin_shirley_sample(vector wo, __constant const float* theta, real u1,
                                                real u2)
{
    const float nu = theta[1];
    const float nv = theta[2];
    real cosine;
    real sine = sine_of_turns(u1, &cosine);
    cosine *= sqrt(nv + 1.0f);
    sine *= sqrt(nu + 1.0f);
    const real e = exponent_at(cosine, sine, nu, nv);
    return reflected(wo, half_of_log(cosine, sine, log(1.0f - u2) / (e + 1.0f)));
}

// Eq. 6 and 8: p = sqrt((nu+1)(nv+1)) / (2 pi) hz^e / (4 c).
static inline real ashikhmin_shirley_density(geometry q, __constant const float* theta)
{
    const float nu = theta[1];
    const float nv = theta[2];
    const real e = exponent_at(q.h_x, q.h_y, nu, nv);
    return sqrt((nu + 1.0f) * (nv + 1.0f)) * (0.125f / PI) * exp(e * log_hz(q) - log(q.c));
}

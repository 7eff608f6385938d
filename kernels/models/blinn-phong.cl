// Blinn 1977, normalised as a distribution of half vectors by solid angle:
//     g = (n + 2) / (2 pi) hz^n,   hz^n = exp(n log(hz))
// theta: n

enum { BLINN_PHONG_LOG_HZ, BLINN_PHONG_PLANES };

static inline void blinn_phong_prepare(geometry q, real* plane) { plane[BLINN_PHONG_LOG_HZ] = log_hz(q); }

static inline real blinn_phong(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const float n = theta[0];
    const real power = exp(n * plane[BLINN_PHONG_LOG_HZ]) * (0.5f / PI);
    const real g = (n + 2.0f) * power;
    d[0] = power + g * plane[BLINN_PHONG_LOG_HZ];
    return g;
}

// Half vectors from (n + 2) / (2 pi) hz^(n+1).
static inline geometry blinn_phong_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    return reflected(wo, half_of_log(cosine, sine, log(u1) / (theta[0] + 2.0f)));
}

// Their density over 4 c.
static inline real blinn_phong_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float n = theta[0];
    return (n + 2.0f) * (0.125f / PI) * exp((n + 1.0f) * log_hz(q) - log(q.c));
}

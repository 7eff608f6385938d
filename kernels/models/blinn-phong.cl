// Blinn 1977, normalised as a distribution: g = (n + 2) / (2 pi) hz^n
// theta: n

static inline void blinn_phong_prepare(geometry q, real* plane) { plane[0] = log_hz(q); }

static inline real blinn_phong(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const float n = theta[0];
    const real power = exp(n * plane[0]) * (0.5f / PI);
    const real g = (n + 2.0f) * power;
    d[0] = power + g * plane[0];
    return g;
}

// Half vectors from (n + 2) / (2 pi) hz^(n+1).
static inline geometry blinn_phong_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    return reflected(wo, half_of_log(cosine, sine, log(u1) / (theta[0] + 2.0f)));
}

static inline real blinn_phong_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float n = theta[0];
    return (n + 2.0f) * (0.125f / PI) * exp((n + 1.0f) * log_hz(q) - log(q.c));
}

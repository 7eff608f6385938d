// Blinn 1977, normalised as a distribution: g = (n + 2) / (2 pi) hz^n
// theta: n

static inline void blinn_phong_prepare(geometry q, real* plane) { plane[0] = log_hz(q); }

static inline real blinn_phong(const real* plane, __constant const float* theta, real* d)
{
    const float n = theta[0];
    const real power = exp(n * plane[0]) * (0.5f / PI);
    const real g = (n + 2.0f) * power;
    d[0] = power + g * plane[0];
    return g;
}

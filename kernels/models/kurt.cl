// Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 10, 11, 14:
//     g = F D / (4 c (iz oz)^alpha),   D = exp(-tan^2_h / m^2) / (pi mx my hz^4)
// computed, as in terms/beckmann.cl, as
//     g = F exp(k - t) / (mx my),   k = -log(4 pi c) - 4 log(hz) - alpha log(iz oz)
// theta: f0, m or mx my, alpha

enum {
    KURT_LOG_COSINES = BECKMANN_PLANES, // -log(iz oz); LOG_FACTOR holds the rest of k
    KURT_P5,
    KURT_PLANES
};

static inline void kurt_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, -log(4.0f * PI * q.c) - 4.0f * log_hz(q), plane);
    plane[KURT_LOG_COSINES] = -log_iz_oz(q);
    plane[KURT_P5] = schlick_p5(q);
}

static inline real kurt(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const float alpha = theta[1 + ROUGHNESSES];
    const real minus_log_iz_oz = plane[KURT_LOG_COSINES];
    const real k = plane[LOG_FACTOR] + alpha * minus_log_iz_oz;
    const real g = beckmann_fresnel_lobe(plane, k, plane[KURT_P5], theta, d);
    d[1 + ROUGHNESSES] = g * minus_log_iz_oz;
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(kurt, theta[1], theta[2])

static inline real kurt_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    return beckmann_by_turn(q, theta[1], theta[2]);
}

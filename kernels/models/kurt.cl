// Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 10, 11, 14:
//     g = F D / (4 c (iz oz)^alpha),   D = exp(-tan^2_h / m^2) / (pi mx my hz^4)
// theta: f0, m or mx my, alpha

static inline void kurt_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI * q.c) - 4.0f * log_hz(q);
    plane[ROUGHNESSES + 1] = -log_iz_oz(q);
    plane[ROUGHNESSES + 2] = schlick_p5(q);
}

static inline real kurt(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const float f0 = theta[0];
    const float alpha = theta[1 + ROUGHNESSES];
    const real minus_log_iz_oz = plane[ROUGHNESSES + 1];
    const real p5 = plane[ROUGHNESSES + 2];
    const real s = beckmann(plane, plane[ROUGHNESSES] + alpha * minus_log_iz_oz, theta + 1, d + 1);
    const real g = schlick_times(p5, f0, s, d);
    scale_by(g, d + 1);
    d[1 + ROUGHNESSES] = g * minus_log_iz_oz;
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(kurt, theta[1], theta[2])

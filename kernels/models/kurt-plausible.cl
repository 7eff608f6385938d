// Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 9: g = F D / (4 c max(iz, oz))
// theta: f0, m or mx my

static inline void kurt_plausible_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI * q.c * fmax(q.wi_z, q.wo_z)) - 4.0f * log_hz(q);
    plane[ROUGHNESSES + 1] = schlick_p5(q);
}

static inline real kurt_plausible(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real p5 = plane[ROUGHNESSES + 1];
    const real s = beckmann(plane, plane[ROUGHNESSES], theta + 1, d + 1);
    const real g = schlick_times(p5, theta[0], s, d);
    scale_by(g, d + 1);
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(kurt_plausible, theta[1], theta[2])

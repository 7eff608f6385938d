// Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 9:
//     g = F D / (4 c max(iz, oz)),   D of terms/beckmann.cl
// computed as F exp(k - t) / (mx my),   k = -log(4 pi c max(iz, oz)) - 4 log(hz)
// theta: f0, m or mx my

enum { KURT_PLAUSIBLE_P5 = BECKMANN_PLANES, KURT_PLAUSIBLE_PLANES };

static inline void kurt_plausible_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, -log(4.0f * PI * q.c * fmax(q.wi_z, q.wo_z)) - 4.0f * log_hz(q), plane);
    plane[KURT_PLAUSIBLE_P5] = schlick_p5(q);
}

static inline real kurt_plausible(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    return beckmann_fresnel_lobe(plane, plane[LOG_FACTOR], plane[KURT_PLAUSIBLE_P5], theta, d);
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(kurt_plausible, theta[1], theta[2])

static inline real kurt_plausible_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    return beckmann_by_turn(q, theta[1], theta[2]);
}

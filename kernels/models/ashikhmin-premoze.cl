// Ashikhmin, Premoze 2007, distribution-based BRDF:
//     g = F D / (4 (iz + oz - iz oz)),   D of terms/beckmann.cl
// computed as F exp(k - t) / (mx my),   k = -log(4 pi (iz + oz - iz oz)) - 4 log(hz)
// theta: f0, m or mx my

enum { ASHIKHMIN_PREMOZE_P5 = BECKMANN_PLANES, ASHIKHMIN_PREMOZE_PLANES };

static inline void ashikhmin_premoze_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, -log(4.0f * PI * (q.wi_z + q.wo_z - q.wi_z * q.wo_z)) - 4.0f * log_hz(q), plane);
    plane[ASHIKHMIN_PREMOZE_P5] = schlick_p5(q);
}

static inline real ashikhmin_premoze(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    return beckmann_fresnel_lobe(plane, plane[LOG_FACTOR], plane[ASHIKHMIN_PREMOZE_P5], theta, d);
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(ashikhmin_premoze, theta[1], theta[2])

static inline real ashikhmin_premoze_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    return beckmann_by_turn(q, theta[1], theta[2]);
}

// Ashikhmin, Premoze 2007, distribution-based BRDF: g = F D / (4 (iz + oz - iz oz))
// theta: f0, m or mx my

static inline void ashikhmin_premoze_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] =
        -log(4.0f * PI * (q.wi_z + q.wo_z - q.wi_z * q.wo_z)) - 4.0f * log_hz(q);
    plane[ROUGHNESSES + 1] = schlick_p5(q);
}

static inline real ashikhmin_premoze(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real p5 = plane[ROUGHNESSES + 1];
    const real s = beckmann(plane, plane[ROUGHNESSES], theta + 1, d + 1);
    const real g = schlick_times(p5, theta[0], s, d);
    scale_by(g, d + 1);
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(ashikhmin_premoze, theta[1], theta[2])

// Duer 2005: g = exp(-tan^2_h / m^2) / (4 pi mx my iz oz)
// theta: m or mx my

static inline void ward_duer_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI) - log_iz_oz(q);
}

static inline real ward_duer(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real g = beckmann(plane, plane[ROUGHNESSES], theta, d);
    scale_by(g, d);
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(ward_duer, theta[0], theta[1])

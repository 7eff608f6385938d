// Ward 1992: g = exp(-tan^2_h / m^2) / (4 pi mx my sqrt(iz oz))
// theta: m or mx my

static inline void ward_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI) - 0.5f * log_iz_oz(q);
}

static inline real ward(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real g = beckmann(plane, plane[ROUGHNESSES], theta, d);
    scale_by(g, d);
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(ward, theta[0], theta[1])

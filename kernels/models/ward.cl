// Ward 1992: g = exp(-tan^2_h / m^2) / (4 pi mx my sqrt(iz oz))
// theta: m or mx my

static inline void ward_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI) - 0.5f * log_iz_oz(q);
}

static inline real ward(const real* plane, __constant const float* theta, real* d)
{
    const real g = beckmann(plane, plane[ROUGHNESSES], theta, d);
    beckmann_scale(g, d);
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
static inline geometry ward_sample(vector wo, __constant const float* theta, real u1, real u2)
{
    return beckmann_sample(wo, theta[0], theta[1], u1, u2);
}

static inline real ward_density(geometry q, __constant const float* theta)
{
    return beckmann_density(q, theta[0], theta[1]);
}

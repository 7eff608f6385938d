// Duer 2005: g = exp(-tan^2_h / m^2) / (4 pi mx my iz oz)
// theta: m or mx my

static inline void ward_duer_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI) - log_iz_oz(q);
}

static inline real ward_duer(const real* plane, __constant const float* theta, real* d)
{
    const real g = beckmann(plane, plane[ROUGHNESSES], theta, d);
    beckmann_scale(g, d);
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
static inline geometry ward_duer_sample(vector wo, __constant const float* theta, real u1, real u2)
{
    return beckmann_sample(wo, theta[0], theta[1], u1, u2);
}

static inline real ward_duer_density(geometry q, __constant const float* theta)
{
    return beckmann_density(q, theta[0], theta[1]);
}

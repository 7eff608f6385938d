// Duer 2005, Ward's model without the root:
//     g = exp(-t) / (4 pi mx my iz oz),   t = tan^2_h (cos^2 phi_h/mx^2 + sin^2 phi_h/my^2)
// which is D hz^4 / (4 iz oz) with D of terms/beckmann.cl; computed as
// exp(k - t) / (mx my),   k = -log(4 pi) - log(iz oz)
// theta: m or mx my

enum { WARD_DUER_PLANES = BECKMANN_PLANES };

static inline void ward_duer_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, -log(4.0f * PI) - log_iz_oz(q), plane);
}

static inline real ward_duer(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    return beckmann_lobe(plane, theta, d);
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(ward_duer, theta[0], theta[1])

static inline real ward_duer_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    return beckmann_by_turn(q, theta[0], theta[1]);
}

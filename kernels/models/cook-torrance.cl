// Cook, Torrance 1981, with the normalised D and the 1/4 of today:
//     g = F D G / (4 iz oz),   G = min(1, 2 hz oz / c, 2 hz iz / c),   D of terms/beckmann.cl, isotropic
// computed as F exp(k - t) / m^2,   t = tan^2_h / m^2,   k = log(G / (iz oz)) - log(4 pi) - 4 log(hz)
// theta: f0, m

enum { COOK_TORRANCE_TAN2, COOK_TORRANCE_LOG_FACTOR, COOK_TORRANCE_P5, COOK_TORRANCE_PLANES };

static inline void cook_torrance_prepare(geometry q, real* plane)
{
    // log(G / (iz oz)) as a minimum of logarithms: the products underflow at grazing.
    const real log_i = log(q.wi_z);
    const real log_o = log(q.wo_z);
    const real edge = log(2.0f * q.h_z / q.c);
    const real log_g = fmin(-log_i - log_o, edge - fmax(log_i, log_o));
    plane[COOK_TORRANCE_TAN2] = tan2_x(q) + tan2_y(q);
    plane[COOK_TORRANCE_LOG_FACTOR] = log_g - log(4.0f * PI) - 4.0f * log_hz(q);
    plane[COOK_TORRANCE_P5] = schlick_p5(q);
}

static inline real cook_torrance(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const float inverse = 1.0f / theta[1];
    const real t = plane[COOK_TORRANCE_TAN2] * (inverse * inverse);
    const real s = exp(plane[COOK_TORRANCE_LOG_FACTOR] - t) * (inverse * inverse);
    const real g = schlick_times(plane[COOK_TORRANCE_P5], theta[0], s, d);
    d[1] = (2.0f * inverse) * (t - 1.0f) * g;
    return g;
}

// Half vectors from D hz, Kurt et al. 2010, Eq. 16-17, 20.
SAMPLES_BECKMANN(cook_torrance, theta[1], theta[1])

// Beckmann's distribution, which the Kurt and Ward families, Cook-Torrance and Beckmann-Smith share:
//     D = exp(-t) / (pi mx my hz^4),
//     t = ((h.x/mx)^2 + (h.y/my)^2) / hz^2 = tan^2_h (cos^2 phi_h/mx^2 + sin^2 phi_h/my^2)
// Each of these models is, but for F,
//     g = exp(k - t) / (mx my)
// with k the logarithm of all factors that depend on the directions alone, log(1 / (pi hz^4) ...): one
// exponential of a sum stays finite where hz^-4 overflows and exp(-t) vanishes. So
//     dlog g/dmx = (2 (h.x/(mx hz))^2 - 1) / mx,   for a single roughness m: dlog g/dm = 2 (t - 1) / m
// ROUGHNESSES: 1 (isotropic form) or 2.

// The planes that these models begin with.
enum {
#if ROUGHNESSES == 1
    TAN2, // tan^2_h
#else
    TAN2_X, // (h.x/hz)^2
    TAN2_Y,
#endif
    LOG_FACTOR, // k
    BECKMANN_PLANES
};

static inline void beckmann_prepare(geometry q, real log_factor, real* plane)
{
#if ROUGHNESSES == 1
    plane[TAN2] = tan2_x(q) + tan2_y(q);
#else
    plane[TAN2_X] = tan2_x(q);
    plane[TAN2_Y] = tan2_y(q);
#endif
    plane[LOG_FACTOR] = log_factor;
}

// exp(k - t) / (mx my), and in d[] the derivative of its logarithm by each roughness.
static inline real beckmann(const real* plane, real k, PARAMETER_SPACE const float* m, real* d)
{
#if ROUGHNESSES == 1
    const float inverse = 1.0f / m[0];
    const real t = plane[TAN2] * (inverse * inverse);
    d[0] = (2.0f * inverse) * (t - 1.0f);
    return exp(k - t) * (inverse * inverse);
#else
    const float ix = 1.0f / m[0];
    const float iy = 1.0f / m[1];
    const real tx = plane[TAN2_X] * (ix * ix);
    const real ty = plane[TAN2_Y] * (iy * iy);
    d[0] = ix * (2.0f * tx - 1.0f);
    d[1] = iy * (2.0f * ty - 1.0f);
    return exp(k - tx - ty) * (ix * iy);
#endif
}

// A lobe without F: theta is m or mx my.
static inline real beckmann_lobe(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real g = beckmann(plane, plane[LOG_FACTOR], theta, d);
    scale_by(g, d);
    return g;
}

// A lobe with F: theta is f0, then m or mx my.
static inline real beckmann_fresnel_lobe(const real* plane, real k, real p5,
                                         PARAMETER_SPACE const float* theta, real* d)
{
    const real s = beckmann(plane, k, theta + 1, d + 1);
    const real g = schlick_times(p5, theta[0], s, d);
    scale_by(g, d + 1);
    return g;
}

// The derivative of log exp(k - t) by the angle of the frame: dh.x = h.y, dh.y = -h.x.
static inline real beckmann_by_turn(geometry q, float mx, float my)
{
    return 2.0f * (q.h_x / q.h_z) * (q.h_y / q.h_z) * (1.0f / (my * my) - 1.0f / (mx * mx));
}

// Beckmann's distribution with its exact height-correlated Smith shadowing (Walter et al. 2007,
// Heitz 2014):
//     g = F D G2 / (4 iz oz),   G2 = 1 / (1 + L(wi) + L(wo)),
//     L = (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi)),   a = w.z / sqrt((w.x mx)^2 + (w.y my)^2)
// theta: f0, m or mx my

static inline void beckmann_smith_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, plane);
    plane[ROUGHNESSES] = -log(4.0f * PI) - log_iz_oz(q) - 4.0f * log_hz(q);
    plane[ROUGHNESSES + 1] = schlick_p5(q);
    const real ix = squared(q.wi_x / q.wi_z);
    const real iy = squared(q.wi_y / q.wi_z);
    const real ox = squared(q.wo_x / q.wo_z);
    const real oy = squared(q.wo_y / q.wo_z);
#if ROUGHNESSES == 1
    plane[3] = ix + iy;
    plane[4] = ox + oy;
#else
    plane[4] = ix;
    plane[5] = ox;
    plane[6] = iy;
    plane[7] = oy;
#endif
}

// L of a direction, and in *slope its derivative by inverse2 = 1 / a^2, times 2.
static inline real beckmann_lambda(real inverse2, real* slope)
{
    // Beyond a = 9 L vanishes, and exp(-a^2) would be a denormal number, slow on many processors; at
    // grazing inverse2, and so L, may be infinite.
    const real a = rsqrt(fmin(fmax(inverse2, (real)(1.0f / 81)), (real)(1e37f)));
    const real gauss = exp(-a * a);
    // erfc(a) = poly(t) exp(-a^2), to 1.5e-7 (Abramowitz and Stegun 7.1.26).
    const real t = 1.0f / (1.0f + 0.3275911f * a);
    const real erfc_share =
        t * (0.254829592f +
             t * (-0.284496736f + t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f))));
    *slope = gauss * a * (0.5f / 1.7724538509f);
    // exp(-a^2) / (2 a sqrt(pi)) = inverse2 *slope
    return fmax(inverse2 * *slope - 0.5f * erfc_share * gauss, (real)(0.0f));
}

static inline real beckmann_smith(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real p5 = plane[ROUGHNESSES + 1];
    real inverse2_i = 0.0f;
    real inverse2_o = 0.0f;
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float m = theta[1 + k];
        inverse2_i += plane[ROUGHNESSES + 2 + 2 * k] * (m * m);
        inverse2_o += plane[ROUGHNESSES + 3 + 2 * k] * (m * m);
    }
    real slope_i, slope_o;
    const real g2 = 1.0f / (1.0f + beckmann_lambda(inverse2_i, &slope_i) +
                            beckmann_lambda(inverse2_o, &slope_o));
    const real s = beckmann(plane, plane[ROUGHNESSES], theta + 1, d + 1) * g2;
    const real g = schlick_times(p5, theta[0], s, d);
    for (int k = 0; k < ROUGHNESSES; ++k) {
        // d (1/a^2) / d m = 2 m tan_k^2
        const float m = theta[1 + k];
        const real by_m = m * (slope_i * plane[ROUGHNESSES + 2 + 2 * k] +
                               slope_o * plane[ROUGHNESSES + 3 + 2 * k]);
        d[1 + k] = g * (d[1 + k] - by_m * g2);
    }
    return g;
}

// 1 + erf(x), to 1.5e-7 (Abramowitz and Stegun 7.1.26); `gauss`: exp(-x^2).
static inline real one_plus_erf(real x, real gauss)
{
    const real t = 1.0f / (1.0f + 0.3275911f * fabs(x));
    const real tail = gauss * t *
                      (0.254829592f +
                       t * (-0.284496736f +
                            t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f))));
    return x < 0.0f ? tail : 2.0f - tail;
}

// The inverse of erf (Giles 2010).
static inline real inverse_erf(real x)
{
    const real w = -log((1.0f - x) * (1.0f + x));
    const real a = w - 2.5f;
    real p = 2.81022636e-08f;
    p = 3.43273939e-07f + p * a;
    p = -3.5233877e-06f + p * a;
    p = -4.39150654e-06f + p * a;
    p = 0.00021858087f + p * a;
    p = -0.00125372503f + p * a;
    p = -0.00417768164f + p * a;
    p = 0.246640727f + p * a;
    p = 1.50140941f + p * a;
    const real b = sqrt(w) - 3.0f;
    real q = -0.000200214257f;
    q = 0.000100950558f + q * b;
    q = 0.00134934322f + q * b;
    q = -0.00367342844f + q * b;
    q = 0.00573950773f + q * b;
    q = -0.0076224613f + q * b;
    q = 0.00943887047f + q * b;
    q = 1.00167406f + q * b;
    q = 2.83297682f + q * b;
    return x * (w < 5.0f ? p : q);
}

// The slope x along a direction at (sine, cosine) from the normal, of normals visible from it: the
// density is (cosine - x sine) exp(-x^2) for x < cosine / sine, its integral
//     cosine (1 + erf x) sqrt(pi) / 2 + sine exp(-x^2) / 2,
// inverted by Newton steps that fall back on halving (Jakob 2014).
static inline real visible_slope(real sine, real cosine, real u)
{
    const float half_root_pi = 0.886226925f;
    real upper = fmin(cosine / fmax(sine, (real)(1e-10f)), (real)(4.5f));
    real lower = -4.5f;
    real gauss = exp(-upper * upper);
    const real wanted =
        u * (cosine * half_root_pi * one_plus_erf(upper, gauss) + 0.5f * sine * gauss);
    // Newton's steps do not overshoot from a start further out where x < 0, which either part of the
    // integral alone gives, and from one further in where x > 0: the second part is at most sine / 2.
    const mask right = wanted > cosine * half_root_pi + 0.5f * sine;
    const real erf_part = inverse_erf(clamp((wanted - (right ? 0.5f * sine : (real)(0.0f))) / (cosine * half_root_pi) - 1.0f,
                                            -0.999999f, 0.999999f));
    const real gauss_part = 2.0f * wanted < sine ? -sqrt(-log(fmax(2.0f * wanted / sine, (real)(1e-9f))))
                                                 : (real)(4.5f);
    real x = clamp(right ? fmax(erf_part, (real)(0.0f)) : fmin(erf_part, gauss_part), lower, upper);
    for (int k = 0; k < 14; ++k) {
        gauss = exp(-x * x);
        const real excess =
            cosine * half_root_pi * one_plus_erf(x, gauss) + 0.5f * sine * gauss - wanted;
        upper = excess > 0.0f ? x : upper;
        lower = excess > 0.0f ? lower : x;
        const real next = x - excess / fmax((cosine - x * sine) * gauss, (real)(1e-20f));
        const real before = x;
        x = next >= lower && next <= upper ? next : 0.5f * (lower + upper);
        if (!any_of(fabs(x - before) > 1e-5f))
            break;
    }
    return x;
}

// Visible normals: slopes of the surface stretched to roughness 1, seen from the stretched wo.
static inline geometry beckmann_smith_sample(vector wo, PARAMETER_SPACE const float* theta, real u1,
                                             real u2)
{
    const float mx = theta[1];
    const float my = theta[2];
    const vector stretched = {mx * wo.x, my * wo.y, wo.z};
    const vector v = unit(stretched);
    const real r2 = v.x * v.x + v.y * v.y;
    const real sine = sqrt(r2);
    const mask tilted = r2 > 1e-30f;
    const real inverse = rsqrt(fmax(r2, (real)(1e-30f)));
    const real cos_phi = tilted ? v.x * inverse : (real)(1.0f);
    const real sin_phi = tilted ? v.y * inverse : (real)(0.0f);
    const real along = visible_slope(sine, v.z, u1);
    const real across = inverse_erf(2.0f * u2 - 1.0f);
    // h leans against its slopes.
    return reflected(wo, half_of_slopes(-mx * (cos_phi * along - sin_phi * across),
                                        -my * (sin_phi * along + cos_phi * across)));
}

// D G1(wo) (wo.h) / oz / (4 c), G1 = 1 / (1 + L(wo)).
static inline real beckmann_smith_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float mx = theta[1];
    const float my = theta[2];
    const real t = squared(q.h_x / q.h_z / mx) + squared(q.h_y / q.h_z / my);
    real slope;
    const real lambda =
        beckmann_lambda(squared(mx * q.wo_x / q.wo_z) + squared(my * q.wo_y / q.wo_z), &slope);
    return exp(-t - 4.0f * log_hz(q)) * (0.25f / PI / mx / my) / (q.wo_z * (1.0f + lambda));
}

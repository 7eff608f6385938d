// Beckmann's distribution with its exact height-correlated Smith shadowing (Walter et al. 2007,
// Heitz 2014):
//     g = F D G2 / (4 iz oz),   G2 = 1 / (1 + L(wi) + L(wo)),   D of terms/beckmann.cl,
//     L = (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi)),   a = w.z / sqrt((w.x mx)^2 + (w.y my)^2)
// computed as F exp(k - t) / (mx my) G2,   k = -log(4 pi) - log(iz oz) - 4 log(hz); and with s = 1 / a^2,
// the sum over x and y of m^2 (w.x/w.z)^2,
//     dL/ds = a exp(-a^2) / (4 sqrt(pi)),   dlog G2/dm = -G2 (dL/ds(wi) ds(wi)/dm + dL/ds(wo) ds(wo)/dm)
// theta: f0, m or mx my

enum {
    BECKMANN_SMITH_P5 = BECKMANN_PLANES,
    BECKMANN_SMITH_TANGENTS,
    BECKMANN_SMITH_PLANES = BECKMANN_SMITH_TANGENTS + 2 * ROUGHNESSES
};
// Squared tangents of wi and wo along the axis of roughness k.
#define TAN2_WI(k) (BECKMANN_SMITH_TANGENTS + 2 * (k))
#define TAN2_WO(k) (BECKMANN_SMITH_TANGENTS + 2 * (k) + 1)

static inline void beckmann_smith_prepare(geometry q, real* plane)
{
    beckmann_prepare(q, -log(4.0f * PI) - log_iz_oz(q) - 4.0f * log_hz(q), plane);
    plane[BECKMANN_SMITH_P5] = schlick_p5(q);
    const real ix = squared(q.wi_x / q.wi_z);
    const real iy = squared(q.wi_y / q.wi_z);
    const real ox = squared(q.wo_x / q.wo_z);
    const real oy = squared(q.wo_y / q.wo_z);
#if ROUGHNESSES == 1
    plane[TAN2_WI(0)] = ix + iy;
    plane[TAN2_WO(0)] = ox + oy;
#else
    plane[TAN2_WI(0)] = ix;
    plane[TAN2_WO(0)] = ox;
    plane[TAN2_WI(1)] = iy;
    plane[TAN2_WO(1)] = oy;
#endif
}

// L of a direction, and in *slope its derivative by inverse2 = 1 / a^2, times 2.
static inline real beckmann_lambda(real inverse2, real* slope)
{
    // Beyond a = 9 L vanishes, and exp(-a^2) would be a denormal number, slow on many processors; at
    // grazing inverse2, and so L, may be infinite.
    const real a = rsqrt(fmin(fmax(inverse2, (real)(1.0f / 81)), (real)(1e37f)));
    const real gauss = exp(-a * a);
    const real t = erfc_variable(a);
    const real erfc_share = t * erfc_polynomial(t); // erfc(a) / gauss
    *slope = gauss * a * (0.5f / 1.7724538509f);
    // exp(-a^2) / (2 a sqrt(pi)) = inverse2 *slope
    return fmax(inverse2 * *slope - 0.5f * erfc_share * gauss, (real)(0.0f));
}

static inline real beckmann_smith(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    real inverse2_i = 0.0f;
    real inverse2_o = 0.0f;
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float m = theta[1 + k];
        inverse2_i += plane[TAN2_WI(k)] * (m * m);
        inverse2_o += plane[TAN2_WO(k)] * (m * m);
    }
    real slope_i, slope_o;
    const real g2 = 1.0f / (1.0f + beckmann_lambda(inverse2_i, &slope_i) +
                            beckmann_lambda(inverse2_o, &slope_o));
    const real s = beckmann(plane, plane[LOG_FACTOR], theta + 1, d + 1) * g2;
    const real g = schlick_times(plane[BECKMANN_SMITH_P5], theta[0], s, d);
    for (int k = 0; k < ROUGHNESSES; ++k) {
        // d (1/a^2) / d m = 2 m tan_k^2
        const float m = theta[1 + k];
        const real by_m = m * (slope_i * plane[TAN2_WI(k)] + slope_o * plane[TAN2_WO(k)]);
        d[1 + k] = g * (d[1 + k] - by_m * g2);
    }
    return g;
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
    const real erf_alone = (wanted - (right ? 0.5f * sine : (real)(0.0f))) / (cosine * half_root_pi) - 1.0f;
    const real erf_part = inverse_erf(clamp(erf_alone, -0.999999f, 0.999999f));
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

static inline real beckmann_smith_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    const float mx = theta[1];
    const float my = theta[2];
    real slope_i, slope_o;
    const real lambda_i =
        beckmann_lambda(squared(mx * q.wi_x / q.wi_z) + squared(my * q.wi_y / q.wi_z), &slope_i);
    const real lambda_o =
        beckmann_lambda(squared(mx * q.wo_x / q.wo_z) + squared(my * q.wo_y / q.wo_z), &slope_o);
    // d (1/a^2) = 2 (w.x/w.z) (w.y/w.z) (mx^2 - my^2); the slopes are twice dL by it
    const real by_lambda = slope_i * (q.wi_x / q.wi_z) * (q.wi_y / q.wi_z) +
                           slope_o * (q.wo_x / q.wo_z) * (q.wo_y / q.wo_z);
    return beckmann_by_turn(q, mx, my) -
           by_lambda * (mx * mx - my * my) / (1.0f + lambda_i + lambda_o);
}

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

// L of a direction, and in *slope its derivative by the logarithm of a. `inverse2`: 1 / a^2.
static inline real beckmann_lambda(real inverse2, real* slope)
{
    const real a = rsqrt(fmax(inverse2, (real)(1e-2f))); // beyond a = 10 L vanishes
    const real gauss = exp(-a * a);
    // erfc(a) = poly(t) exp(-a^2), to 1.5e-7 (Abramowitz and Stegun 7.1.26).
    const real t = 1.0f / (1.0f + 0.3275911f * a);
    const real erfc_share =
        t * (0.254829592f +
             t * (-0.284496736f + t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f))));
    const real edge = gauss / a * (0.5f / 1.7724538509f);
    *slope = -edge;
    return fmax(edge - 0.5f * erfc_share * gauss, (real)(0.0f));
}

static inline real beckmann_smith(const real* plane, __constant const float* theta, real* d)
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
    const real inverse_g2 =
        1.0f + beckmann_lambda(inverse2_i, &slope_i) + beckmann_lambda(inverse2_o, &slope_o);
    const real s = beckmann(plane, plane[ROUGHNESSES], theta + 1, d + 1) / inverse_g2;
    const real g = schlick(p5, theta[0]) * s;
    d[0] = (1.0f - p5) * s;
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float m = theta[1 + k];
        // d log a / d m = -m tan_k^2 / (1/a^2)
        const real log_a_i =
            -m * plane[ROUGHNESSES + 2 + 2 * k] / fmax(inverse2_i, (real)(1e-30f));
        const real log_a_o =
            -m * plane[ROUGHNESSES + 3 + 2 * k] / fmax(inverse2_o, (real)(1e-30f));
        d[1 + k] = g * (d[1 + k] - (slope_i * log_a_i + slope_o * log_a_o) / inverse_g2);
    }
    return g;
}

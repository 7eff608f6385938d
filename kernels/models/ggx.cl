// Trowbridge-Reitz (Walter et al. 2007) with height-correlated Smith shadowing (Heitz 2014):
//     g = F D G2 / (4 iz oz),   D = 1 / (pi ax ay E^2),   E = (h.x/ax)^2 + (h.y/ay)^2 + hz^2,
//     G2 = 1 / (1 + L(wi) + L(wo)),   L(w) = (sqrt(1 + ((w.x ax)^2 + (w.y ay)^2) / w.z^2) - 1) / 2
// so that 4 iz oz / G2 = 2 (oz A(wi) + iz A(wo)) with A(w) = sqrt((w.x ax)^2 + (w.y ay)^2 + w.z^2).
// theta: f0, a or ax ay

static inline void ggx_prepare(geometry q, real* plane) { trowbridge_reitz_prepare(q, plane); }

static inline real ggx(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real iz = plane[3 * ROUGHNESSES + 1];
    const real oz = plane[3 * ROUGHNESSES + 2];
    const real p5 = plane[3 * ROUGHNESSES + 3];
    real e = plane[3 * ROUGHNESSES];
    real a_i = iz * iz;
    real a_o = oz * oz;
    float product = 1.0f; // ax ay
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float a = theta[1 + k];
        e += plane[3 * k] * (1.0f / (a * a));
        a_i += plane[3 * k + 1] * (a * a);
        a_o += plane[3 * k + 2] * (a * a);
        product *= ROUGHNESSES == 1 ? a * a : a;
    }
    a_i = sqrt(a_i);
    a_o = sqrt(a_o);
    const real v = oz * a_i + iz * a_o;
    const real a_i_o = a_i * a_o;
    const real inverse_v = 1.0f / v;
    const real inverse = 1.0f / (e * a_i_o); // one division for two
    const real inverse_e = inverse * a_i_o;
    const real s = (0.5f / PI / product) * inverse_v * (inverse_e * inverse_e);
    const real g = schlick_times(p5, theta[0], s, d);
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float a = theta[1 + k];
        const real by_e = plane[3 * k] * (4.0f / (a * a * a)) * inverse_e;
        const real by_v = (oz * plane[3 * k + 1] * a_o + iz * plane[3 * k + 2] * a_i) *
                          (a * inverse_v * inverse * e);
        d[1 + k] = g * (by_e - by_v - (ROUGHNESSES == 1 ? 2.0f : 1.0f) / a);
    }
    return g;
}

static inline geometry ggx_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    return trowbridge_reitz_sample(wo, theta[1], theta[2], u1, u2);
}

static inline real ggx_density(geometry q, PARAMETER_SPACE const float* theta)
{
    return trowbridge_reitz_density(q, theta[1], theta[2]);
}

// Trowbridge-Reitz (Walter et al. 2007) with height-correlated Smith shadowing (Heitz 2014):
//     g = F D G2 / (4 iz oz),   G2 = 1 / (1 + L(wi) + L(wo)),   L(w) = (A(w) / w.z - 1) / 2
// D, E and A of terms/trowbridge_reitz.cl. As 4 iz oz / G2 = 2 (oz A(wi) + iz A(wo)) = 2 V,
//     g = F / (2 pi ax ay V E^2),   dlog g/da_k = -2 dlog E/da_k - dlog V/da_k - 1 / a_k
//     dV/da_k = a_k (oz wi_k^2 / A(wi) + iz wo_k^2 / A(wo))
// theta: f0, a or ax ay

enum { GGX_PLANES = TROWBRIDGE_REITZ_PLANES };

static inline void ggx_prepare(geometry q, real* plane) { trowbridge_reitz_prepare(q, plane); }

static inline real ggx(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const trowbridge_reitz t = trowbridge_reitz_of(plane, theta + 1);
    const real v = t.oz * t.a_i + t.iz * t.a_o;
    const real a_i_o = t.a_i * t.a_o;
    const real inverse_v = 1.0f / v;
    const real inverse = 1.0f / (t.e * a_i_o); // one division for two
    const real inverse_e = inverse * a_i_o;
    const real s = (0.5f / PI / t.ax_ay) * inverse_v * (inverse_e * inverse_e);
    const real g = schlick_times(t.p5, theta[0], s, d);
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float a = theta[1 + k];
        const real by_e = plane[H2(k)] * (4.0f / (a * a * a)) * inverse_e;
        const real by_v = (t.oz * plane[WI2(k)] * t.a_o + t.iz * plane[WO2(k)] * t.a_i) *
                          (a * inverse_v * inverse * t.e);
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

static inline real ggx_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    const float ax = theta[1];
    const float ay = theta[2];
    real plane[GGX_PLANES];
    ggx_prepare(q, plane);
    const trowbridge_reitz t = trowbridge_reitz_of(plane, theta + 1);
    const real v = t.oz * t.a_i + t.iz * t.a_o;
    const real by_v = t.oz * a_by_turn(q.wi_x, q.wi_y, t.a_i, ax, ay) +
                      t.iz * a_by_turn(q.wo_x, q.wo_y, t.a_o, ax, ay);
    return -2.0f * e_by_turn(q, ax, ay) / t.e - by_v / v;
}

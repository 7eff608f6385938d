// Trowbridge-Reitz with Smith shadowing and masking taken as independent (Walter et al. 2007, Eq. 23):
//     g = F D G1(wi) G1(wo) / (4 iz oz),   G1(w) = 1 / (1 + L(w)) = 2 w.z / (w.z + A(w))
// D, E, A and L of terms/trowbridge_reitz.cl; so that
//     g = F / (pi ax ay (iz + A(wi)) (oz + A(wo)) E^2),
//     dlog g/da_k = -2 dlog E/da_k - dlog (iz + A(wi))/da_k - dlog (oz + A(wo))/da_k - 1 / a_k
// theta: f0, a or ax ay

enum { GGX_UNCORRELATED_PLANES = TROWBRIDGE_REITZ_PLANES };

static inline void ggx_uncorrelated_prepare(geometry q, real* plane) { trowbridge_reitz_prepare(q, plane); }

static inline real ggx_uncorrelated(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const trowbridge_reitz t = trowbridge_reitz_of(plane, theta + 1);
    const real inverse_i = 1.0f / (t.iz + t.a_i);
    const real inverse_o = 1.0f / (t.oz + t.a_o);
    const real s = (1.0f / PI / t.ax_ay) * inverse_i * inverse_o / (t.e * t.e);
    const real g = schlick_times(t.p5, theta[0], s, d);
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float a = theta[1 + k];
        const real by_e = plane[H2(k)] * (4.0f / (a * a * a)) / t.e;
        const real by_v = a * (plane[WI2(k)] / t.a_i * inverse_i + plane[WO2(k)] / t.a_o * inverse_o);
        d[1 + k] = g * (by_e - by_v - (ROUGHNESSES == 1 ? 2.0f : 1.0f) / a);
    }
    return g;
}

static inline geometry ggx_uncorrelated_sample(vector wo, PARAMETER_SPACE const float* theta, real u1,
                                               real u2)
{
    return trowbridge_reitz_sample(wo, theta[1], theta[2], u1, u2);
}

static inline real ggx_uncorrelated_density(geometry q, PARAMETER_SPACE const float* theta)
{
    return trowbridge_reitz_density(q, theta[1], theta[2]);
}

static inline real ggx_uncorrelated_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    const float ax = theta[1];
    const float ay = theta[2];
    real plane[GGX_UNCORRELATED_PLANES];
    ggx_uncorrelated_prepare(q, plane);
    const trowbridge_reitz t = trowbridge_reitz_of(plane, theta + 1);
    return -2.0f * e_by_turn(q, ax, ay) / t.e -
           a_by_turn(q.wi_x, q.wi_y, t.a_i, ax, ay) / (t.iz + t.a_i) -
           a_by_turn(q.wo_x, q.wo_y, t.a_o, ax, ay) / (t.oz + t.a_o);
}

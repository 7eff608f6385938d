// Trowbridge-Reitz with Smith shadowing and masking taken as independent (Walter et al. 2007, Eq. 23):
//     g = F D G1(wi) G1(wo) / (4 iz oz),   G1(w) = 1 / (1 + L(w)) = 2 w.z / (w.z + A(w))
// so that g = F D / ((iz + A(wi)) (oz + A(wo))); D, L and A as in trowbridge_reitz.cl.
// theta: f0, a or ax ay

static inline void ggx_uncorrelated_prepare(geometry q, real* plane) { trowbridge_reitz_prepare(q, plane); }

static inline real ggx_uncorrelated(const real* plane, PARAMETER_SPACE const float* theta, real* d)
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
    const real inverse_i = 1.0f / (iz + a_i);
    const real inverse_o = 1.0f / (oz + a_o);
    const real s = (1.0f / PI / product) * inverse_i * inverse_o / (e * e);
    const real g = schlick_times(p5, theta[0], s, d);
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float a = theta[1 + k];
        const real by_e = plane[3 * k] * (4.0f / (a * a * a)) / e;
        const real by_v =
            a * (plane[3 * k + 1] / a_i * inverse_i + plane[3 * k + 2] / a_o * inverse_o);
        d[1 + k] = g * (by_e - by_v - (ROUGHNESSES == 1 ? 2.0f : 1.0f) / a);
    }
    return g;
}

static inline geometry ggx_uncorrelated_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    return trowbridge_reitz_sample(wo, theta[1], theta[2], u1, u2);
}

static inline real ggx_uncorrelated_density(geometry q, PARAMETER_SPACE const float* theta)
{
    return trowbridge_reitz_density(q, theta[1], theta[2]);
}

// Trowbridge-Reitz (Walter et al. 2007) with height-correlated Smith shadowing (Heitz 2014):
//     g = F D G2 / (4 iz oz),   D = 1 / (pi ax ay E^2),   E = (h.x/ax)^2 + (h.y/ay)^2 + hz^2,
//     G2 = 1 / (1 + L(wi) + L(wo)),   L(w) = (sqrt(1 + ((w.x ax)^2 + (w.y ay)^2) / w.z^2) - 1) / 2
// so that 4 iz oz / G2 = 2 (oz A(wi) + iz A(wo)) with A(w) = sqrt((w.x ax)^2 + (w.y ay)^2 + w.z^2).
// theta: f0, a or ax ay

static inline void ggx_prepare(geometry q, real* plane)
{
#if ROUGHNESSES == 1
    plane[0] = q.h_x * q.h_x + q.h_y * q.h_y;
    plane[1] = q.wi_x * q.wi_x + q.wi_y * q.wi_y;
    plane[2] = q.wo_x * q.wo_x + q.wo_y * q.wo_y;
#else
    plane[0] = q.h_x * q.h_x;
    plane[1] = q.wi_x * q.wi_x;
    plane[2] = q.wo_x * q.wo_x;
    plane[3] = q.h_y * q.h_y;
    plane[4] = q.wi_y * q.wi_y;
    plane[5] = q.wo_y * q.wo_y;
#endif
    plane[3 * ROUGHNESSES] = q.h_z * q.h_z;
    plane[3 * ROUGHNESSES + 1] = q.wi_z;
    plane[3 * ROUGHNESSES + 2] = q.wo_z;
    plane[3 * ROUGHNESSES + 3] = schlick_p5(q);
}

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

// Visible normals by Heitz 2018: wo in the space where the surface is a hemisphere, a point of its
// projection, and back.
static inline geometry ggx_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    const float ax = theta[1];
    const float ay = theta[2];
    const vector stretched = {ax * wo.x, ay * wo.y, wo.z};
    const vector v = unit(stretched);
    const real r2 = v.x * v.x + v.y * v.y;
    const mask tilted = r2 > 1e-30f;
    const real inverse = rsqrt(fmax(r2, (real)(1e-30f)));
    const vector t1 = {tilted ? -v.y * inverse : (real)(1.0f), tilted ? v.x * inverse : (real)(0.0f),
                       (real)(0.0f)};
    const vector t2 = {-v.z * t1.y, v.z * t1.x, v.x * t1.y - v.y * t1.x};
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    const real r = sqrt(u1);
    const real p1 = r * cosine;
    const real s = 0.5f * (1.0f + v.z);
    const real p2 = (1.0f - s) * sqrt(fmax(1.0f - p1 * p1, (real)(0.0f))) + s * r * sine;
    const real p3 = sqrt(fmax(1.0f - p1 * p1 - p2 * p2, (real)(0.0f)));
    const vector h = {ax * (p1 * t1.x + p2 * t2.x + p3 * v.x), ay * (p1 * t1.y + p2 * t2.y + p3 * v.y),
                      fmax(p2 * t2.z + p3 * v.z, (real)(1e-7f))};
    return reflected(wo, unit(h));
}

// D G1(wo) (wo.h) / oz / (4 c) = D / (2 (oz + A(wo))).
static inline real ggx_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float ax = theta[1];
    const float ay = theta[2];
    const real e = squared(q.h_x / ax) + squared(q.h_y / ay) + squared(q.h_z);
    const real a = sqrt(squared(q.wo_x * ax) + squared(q.wo_y * ay) + squared(q.wo_z));
    return (0.5f / PI / ax / ay) / (e * e * (q.wo_z + a));
}

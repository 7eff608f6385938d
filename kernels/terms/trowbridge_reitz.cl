// What the models with Trowbridge and Reitz's distribution share: planes, and visible normals.
//     D = 1 / (pi ax ay E^2), E = (h.x/ax)^2 + (h.y/ay)^2 + hz^2,
//     A(w) = sqrt((w.x ax)^2 + (w.y ay)^2 + w.z^2), L(w) = (A(w) / w.z - 1) / 2
// ROUGHNESSES: 1 (isotropic form, 7 planes) or 2 (10 planes).

static inline void trowbridge_reitz_prepare(geometry q, real* plane)
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

// Visible normals by Heitz 2018: wo in the space where the surface is a hemisphere, a point of its
// projection, and back.
static inline geometry trowbridge_reitz_sample(vector wo, float ax, float ay, real u1, real u2)
{
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
static inline real trowbridge_reitz_density(geometry q, float ax, float ay)
{
    const real e = squared(q.h_x / ax) + squared(q.h_y / ay) + squared(q.h_z);
    const real a = sqrt(squared(q.wo_x * ax) + squared(q.wo_y * ay) + squared(q.wo_z));
    return (0.5f / PI / ax / ay) / (e * e * (q.wo_z + a));
}

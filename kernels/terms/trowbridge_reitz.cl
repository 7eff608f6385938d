// What the models with Trowbridge and Reitz's distribution share (Walter et al. 2007, Heitz 2014): planes,
// and visible normals.
//     D = 1 / (pi ax ay E^2),   E = (h.x/ax)^2 + (h.y/ay)^2 + hz^2,
//     A(w) = sqrt((w.x ax)^2 + (w.y ay)^2 + w.z^2),   Smith's L(w) = (A(w) / w.z - 1) / 2
//     dE/dax = -2 h.x^2 / ax^3,   dA/dax = ax w.x^2 / A
// ROUGHNESSES: 1 (isotropic form, x and y together) or 2.

// The planes: for each roughness k the squares of h, wi and wo along its axis, then the rest.
#define H2(k) (3 * (k))
#define WI2(k) (3 * (k) + 1)
#define WO2(k) (3 * (k) + 2)
enum {
    HZ2 = 3 * ROUGHNESSES, // hz^2
    COSINE_I,              // iz
    COSINE_O,              // oz
    TROWBRIDGE_REITZ_P5,   // (1 - c)^5
    TROWBRIDGE_REITZ_PLANES
};

static inline void trowbridge_reitz_prepare(geometry q, real* plane)
{
#if ROUGHNESSES == 1
    plane[H2(0)] = q.h_x * q.h_x + q.h_y * q.h_y;
    plane[WI2(0)] = q.wi_x * q.wi_x + q.wi_y * q.wi_y;
    plane[WO2(0)] = q.wo_x * q.wo_x + q.wo_y * q.wo_y;
#else
    plane[H2(0)] = q.h_x * q.h_x;
    plane[WI2(0)] = q.wi_x * q.wi_x;
    plane[WO2(0)] = q.wo_x * q.wo_x;
    plane[H2(1)] = q.h_y * q.h_y;
    plane[WI2(1)] = q.wi_y * q.wi_y;
    plane[WO2(1)] = q.wo_y * q.wo_y;
#endif
    plane[HZ2] = q.h_z * q.h_z;
    plane[COSINE_I] = q.wi_z;
    plane[COSINE_O] = q.wo_z;
    plane[TROWBRIDGE_REITZ_P5] = schlick_p5(q);
}

typedef struct {
    real iz, oz, p5;
    real e;        // E
    real a_i, a_o; // A(wi), A(wo)
    float ax_ay;
} trowbridge_reitz;

// E and A at the roughness a, or ax ay.
static inline trowbridge_reitz trowbridge_reitz_of(const real* plane, PARAMETER_SPACE const float* roughness)
{
    trowbridge_reitz t;
    t.iz = plane[COSINE_I];
    t.oz = plane[COSINE_O];
    t.p5 = plane[TROWBRIDGE_REITZ_P5];
    t.e = plane[HZ2];
    t.a_i = t.iz * t.iz;
    t.a_o = t.oz * t.oz;
    t.ax_ay = 1.0f;
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float a = roughness[k];
        t.e += plane[H2(k)] * (1.0f / (a * a));
        t.a_i += plane[WI2(k)] * (a * a);
        t.a_o += plane[WO2(k)] * (a * a);
        t.ax_ay *= ROUGHNESSES == 1 ? a * a : a;
    }
    t.a_i = sqrt(t.a_i);
    t.a_o = sqrt(t.a_o);
    return t;
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

// The derivatives by the angle of the frame (dx = y, dy = -x) of E and of A(w).
static inline real e_by_turn(geometry q, float ax, float ay)
{
    return 2.0f * q.h_x * q.h_y * (1.0f / (ax * ax) - 1.0f / (ay * ay));
}

static inline real a_by_turn(real x, real y, real a, float ax, float ay)
{
    return x * y * (ax * ax - ay * ay) / a;
}

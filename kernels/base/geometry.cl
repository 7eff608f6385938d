// Directions in the local frame: x tangent, y bitangent, z normal; wi to the light, wo to the viewer,
// h = (wi + wo) / |wi + wo|, c = wi.h = wo.h; iz, oz and hz in formulas are wi.z, wo.z and h.z. As planes,
// in the order of direction_planes.h.

typedef struct {
    real wi_x, wi_y, wi_z; // unit, wi_z > 0
    real wo_x, wo_y, wo_z; // unit, wo_z > 0
    real h_x, h_y, h_z;    // unit, h_z > 0
    real c;                // (0, 1]
} geometry;

static inline geometry geometry_of(const real* plane)
{
    geometry q;
    q.wi_x = plane[WI_X];
    q.wi_y = plane[WI_Y];
    q.wi_z = plane[WI_Z];
    q.wo_x = plane[WO_X];
    q.wo_y = plane[WO_Y];
    q.wo_z = plane[WO_Z];
    q.h_x = plane[H_X];
    q.h_y = plane[H_Y];
    q.h_z = plane[H_Z];
    q.c = plane[HALF_COSINE];
    return q;
}

// Fills the planes WI_X to WO_Z.
static inline void write_directions(geometry q, real* plane)
{
    plane[WI_X] = q.wi_x;
    plane[WI_Y] = q.wi_y;
    plane[WI_Z] = q.wi_z;
    plane[WO_X] = q.wo_x;
    plane[WO_Y] = q.wo_y;
    plane[WO_Z] = q.wo_z;
}

// Fills all DIRECTION_PLANES.
static inline void write_geometry(geometry q, real* plane)
{
    write_directions(q, plane);
    plane[H_X] = q.h_x;
    plane[H_Y] = q.h_y;
    plane[H_Z] = q.h_z;
    plane[HALF_COSINE] = q.c;
}

// log(1 - lost) for lost < 1/2, exact also where 1 - lost rounds to 1 (Kahan: the rounding of the
// difference is in both factors); otherwise log(x).
static inline real log_one_minus(real lost, real x)
{
    const mask small = lost < 0.5f;
    const real y = small ? 1.0f - lost : x;
    const real rounded = 1.0f - y;
    const real l = log(y);
    return small ? (rounded > 0.0f ? l * (lost / rounded) : -lost) : l;
}

// log(h.z), exact near the pole where h.z rounds to 1.
static inline real log_hz(geometry q)
{
    const real s = q.h_x * q.h_x + q.h_y * q.h_y;
    const real l = log_one_minus(s, q.h_z);
    return s < 0.5f ? 0.5f * l : l;
}

static inline real log_iz_oz(geometry q) { return log(q.wi_z) + log(q.wo_z); }

// Tangents of the half vector, squared: (h.x/h.z)^2 and (h.y/h.z)^2; divided first, as hz^2 may
// underflow.
static inline real squared(real x) { return x * x; }
static inline real tan2_x(geometry q) { return squared(q.h_x / q.h_z); }
static inline real tan2_y(geometry q) { return squared(q.h_y / q.h_z); }

static inline geometry read_geometry(__global const real* directions, uint stride, uint i)
{
    real p[DIRECTION_PLANES];
    for (int k = 0; k < DIRECTION_PLANES; ++k)
        p[k] = directions[i + k * stride];
    return geometry_of(p);
}

// A geometry that no model overflows at, for lanes below the horizon.
static inline geometry above_horizon(geometry q, mask above)
{
    q.wi_z = above ? q.wi_z : (real)(1.0f);
    q.wo_z = above ? q.wo_z : (real)(1.0f);
    q.h_x = above ? q.h_x : (real)(0.0f);
    q.h_y = above ? q.h_y : (real)(0.0f);
    q.h_z = above ? q.h_z : (real)(1.0f);
    q.c = above ? q.c : (real)(1.0f);
    return q;
}

// A BRDF value: 0 below the horizon, finite above it.
static inline real finite_above(real f, mask above)
{
    return above ? fmin(f, (real)(FLT_MAX)) : (real)(0.0f);
}

// Turns the derivatives of log g by the roughnesses or exponents into those of g.
static inline void scale_by(real g, real* d)
{
    for (int k = 0; k < ROUGHNESSES; ++k)
        d[k] *= g;
}

// The geometry in a frame turned by that angle from x towards y.
static inline geometry turned(geometry q, float cosine, float sine)
{
    geometry t = q;
    t.wi_x = cosine * q.wi_x + sine * q.wi_y;
    t.wi_y = cosine * q.wi_y - sine * q.wi_x;
    t.wo_x = cosine * q.wo_x + sine * q.wo_y;
    t.wo_y = cosine * q.wo_y - sine * q.wo_x;
    t.h_x = cosine * q.h_x + sine * q.h_y;
    t.h_y = cosine * q.h_y - sine * q.h_x;
    return t;
}

// Shapes of a scene (scene_words.h): where rays meet them. All are convex, so that a ray that starts on
// one and leaves it never meets it again.

static inline vector vector_of(__global const float* word)
{
    const vector v = {(real)(word[0]), (real)(word[1]), (real)(word[2])};
    return v;
}

static inline vector plus(vector a, vector b)
{
    const vector c = {a.x + b.x, a.y + b.y, a.z + b.z};
    return c;
}

static inline vector minus(vector a, vector b)
{
    const vector c = {a.x - b.x, a.y - b.y, a.z - b.z};
    return c;
}

static inline vector crossed(vector a, vector b)
{
    const vector c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return c;
}

static inline vector chosen(mask first, vector a, vector b)
{
    const vector c = {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
    return c;
}

static inline __global const float* shape_words(__global const float* scene, int k)
{
    return scene + SCENE_WORDS + k * SHAPE_WORDS;
}

// Where a ray enters a shape, by its length; infinite where it does not. The discriminant is that of
// the point nearest to the centre (Haines et al. 2019), which does not cancel far away.
static inline real sphere_entry(__global const float* shape, vector at, vector to)
{
    const vector from = minus(at, vector_of(shape + SHAPE_AT));
    const real along = -dot3(from, to);
    const vector nearest = plus(from, scaled(to, along));
    const real left = squared(shape[SHAPE_RADIUS]) - dot3(nearest, nearest);
    return left > 0.0f ? along - sqrt(fmax(left, (real)(0.0f))) : (real)(INFINITY);
}

// Enters both the slab between the ends and the endless cylinder before it leaves either.
static inline real cylinder_entry(__global const float* shape, vector at, vector to)
{
    const vector from = minus(at, vector_of(shape + SHAPE_AT));
    const real slope = 1.0f / to.x;
    const real one = (-shape[SHAPE_HALF_LENGTH] - from.x) * slope;
    const real other = (shape[SHAPE_HALF_LENGTH] - from.x) * slope;
    const real a = fmax(to.y * to.y + to.z * to.z, (real)(1e-30f));
    const real along = -(from.y * to.y + from.z * to.z) / a;
    const real y = from.y + along * to.y;
    const real z = from.z + along * to.z;
    const real left = squared(shape[SHAPE_RADIUS]) - y * y - z * z;
    const real within = sqrt(fmax(left, (real)(0.0f)) / a);
    const real enter = fmax(fmin(one, other), along - within);
    const real leave = fmin(fmax(one, other), along + within);
    return left > 0.0f && enter < leave ? enter : (real)(INFINITY);
}

static inline real disc_entry(__global const float* shape, vector at, vector to)
{
    const real t = (shape[SHAPE_AT + 2] - at.z) / to.z;
    const real x = at.x + t * to.x - shape[SHAPE_AT];
    const real y = at.y + t * to.y - shape[SHAPE_AT + 1];
    return to.z < 0.0f && x * x + y * y < squared(shape[SHAPE_RADIUS]) ? t : (real)(INFINITY);
}

typedef struct {
    real t;     // infinite: the ray meets nothing
    mask shape; // -1: none
} meeting;

// What a ray meets first that starts on shape `own`, -1: on none.
static inline meeting first_met(__global const float* scene, vector at, vector to, mask own)
{
    meeting m = {(real)(INFINITY), (mask)(-1)};
    for (int k = 0; k < (int)scene[SHAPES]; ++k) {
        __global const float* shape = shape_words(scene, k);
        const int kind = shape[SHAPE_KIND];
        const real t = kind == SPHERE     ? sphere_entry(shape, at, to)
                       : kind == CYLINDER ? cylinder_entry(shape, at, to)
                                          : disc_entry(shape, at, to);
        const mask nearer = t > 0.0f && t < m.t && own != (mask)(k);
        m.t = nearer ? t : m.t;
        m.shape = nearer ? (mask)(k) : m.shape;
    }
    return m;
}

// A point of a surface with its frame: x tangent, y bitangent, z normal, all in the scene's directions.
typedef struct {
    vector at, x, y, z;
    mask ground;
} surface;

// Unit vector around an axis (a point's offset from it is (a, b)), anything on the axis itself.
static inline void around_axis(real a, real b, real* across_a, real* across_b)
{
    const real r2 = a * a + b * b;
    const mask off = r2 > 1e-12f;
    const real inverse = rsqrt(fmax(r2, (real)(1e-12f)));
    *across_a = off ? -b * inverse : (real)(1.0f);
    *across_b = off ? a * inverse : (real)(0.0f);
}

static inline surface surface_of(__global const float* shape, vector at)
{
    const int kind = shape[SHAPE_KIND];
    const vector centre = vector_of(shape + SHAPE_AT);
    const vector from = minus(at, centre);
    const vector up = {(real)(0.0f), (real)(0.0f), (real)(1.0f)};
    surface s;
    s.at = at;
    s.z = up;
    vector around = {(real)(1.0f), (real)(0.0f), (real)(0.0f)};
    vector along = around;
    if (kind == CYLINDER) {
        const real side2 = from.y * from.y + from.z * from.z;
        // On an end the offset along the axis says more than the one across.
        const mask end = shape[SHAPE_HALF_LENGTH] - fabs(from.x) <
                         shape[SHAPE_RADIUS] - sqrt(side2);
        const real inverse = rsqrt(fmax(side2, (real)(1e-30f)));
        const vector side = {(real)(0.0f), from.y * inverse, from.z * inverse};
        const vector face = {sign(from.x), (real)(0.0f), (real)(0.0f)};
        s.z = chosen(end, face, side);
        around.x = 0.0f;
        around_axis(from.y, from.z, &around.y, &around.z);
        along = crossed(around, s.z);
    } else {
        if (kind == SPHERE) {
            s.z = scaled(from, 1.0f / shape[SHAPE_RADIUS]);
            s.z = scaled(s.z, 1.5f - 0.5f * dot3(s.z, s.z)); // Newton's step to length 1
            s.at = plus(centre, scaled(s.z, (real)(shape[SHAPE_RADIUS])));
        }
        if (kind == SPHERE || shape[SHAPE_BRUSHED] == AROUND)
            around_axis(from.x, from.y, &around.x, &around.y);
        if (kind == SPHERE)
            along = crossed(around, s.z);
    }
    s.x = shape[SHAPE_BRUSHED] == AROUND ? around : along;
    s.y = crossed(s.z, s.x);
    s.ground = (mask)(shape[SHAPE_IS_GROUND] > 0.0f) != (mask)(0);
    return s;
}

// The surface where a ray meets a shape.
static inline surface surface_met(__global const float* scene, vector at, vector to, meeting m)
{
    const vector point = plus(at, scaled(to, m.shape >= 0 ? m.t : (real)(0.0f)));
    surface s = surface_of(shape_words(scene, 0), point);
    for (int k = 1; k < (int)scene[SHAPES]; ++k) {
        const mask mine = m.shape == (mask)(k);
        if (!any_of(mine))
            continue;
        const surface other = surface_of(shape_words(scene, k), point);
        s.at = chosen(mine, other.at, s.at);
        s.x = chosen(mine, other.x, s.x);
        s.y = chosen(mine, other.y, s.y);
        s.z = chosen(mine, other.z, s.z);
        s.ground = mine ? other.ground : s.ground;
    }
    return s;
}

static inline vector to_local(surface s, vector v)
{
    const vector w = {dot3(v, s.x), dot3(v, s.y), dot3(v, s.z)};
    return w;
}

static inline vector from_local(surface s, vector v)
{
    return plus(plus(scaled(s.x, v.x), scaled(s.y, v.y)), scaled(s.z, v.z));
}

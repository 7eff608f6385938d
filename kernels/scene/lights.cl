// Lights of a scene (scene_words.h): what they send along a ray, and directions drawn to them.
//
// An environment is a picture, constant within each texel: rows are equal steps of the angle from z,
// from the top, columns equal steps of azimuth, from left to right clockwise seen from above; the middle
// looks along x.

// A texel, and the cell of the same number of an alias table (Walker 1977, Vose 1991): together, because
// most of what is drawn is its own cell, and reading what is not in the caches costs more than computing.
typedef struct {
    float4 light;  // red, green, blue; the density by which a direction in it is drawn, by solid angle
    uint own;      // the cell is this texel so often of 2^32 times,
    uint other;    // and otherwise this one
    uint unused[2];
} texel;

// The power heuristic with exponent 2 (Veach and Guibas 1995): the weight of a direction drawn with
// density `own` that would also have been drawn with density `other`. The two weights of a direction sum
// to 1. `own` may be infinite, a light that nothing else finds.
static inline real shared_weight(real own, real other)
{
    const real ratio = other / own;
    return own > 0.0f ? 1.0f / (1.0f + ratio * ratio) : (real)(0.0f);
}

#if V == 1
#define AS_MASK as_int
#define TO_REAL convert_float
#define TO_MASK convert_int
#else
#define AS_MASK JOIN(as_int, V)
#define TO_REAL JOIN(convert_float, V)
#define TO_MASK JOIN(convert_int, V)
#endif

static inline mask whole(real x) { return TO_MASK(x); }

// Has what is read a little later brought near, on a CPU: a picture of the sky is larger than its caches.
// Compilers for SPIR do not all know how.
static inline void fetch_texels(__global const texel* texels, mask index)
{
#if defined(__has_builtin) && (defined(__x86_64__) || defined(__aarch64__))
#if __has_builtin(__builtin_prefetch)
    for (int lane = 0; lane < V; ++lane)
        __builtin_prefetch(texels + ((int*)&index)[lane]);
#endif
#endif
}

static inline void light_of(__global const texel* texels, mask index, real* rgb, real* density)
{
    for (int lane = 0; lane < V; ++lane) {
        const float4 light = texels[((int*)&index)[lane]].light;
        ((float*)&rgb[0])[lane] = light.x;
        ((float*)&rgb[1])[lane] = light.y;
        ((float*)&rgb[2])[lane] = light.z;
        ((float*)density)[lane] = light.w;
    }
}

// The environment's texel in a direction.
static inline mask texel_towards(__global const float* scene, vector to)
{
    const float columns = scene[ENVIRONMENT_WIDTH];
    const float rows = scene[ENVIRONMENT_HEIGHT];
    const real turn = 0.5f + scene[ENVIRONMENT_TURN] - atan2(to.y, to.x) * (0.5f / PI);
    const real x = fmin((turn - floor(turn)) * columns, (real)(columns - 1.0f));
    const real y = fmin(acos(clamp(to.z, (real)(-1.0f), (real)(1.0f))) * (rows / PI), (real)(rows - 1.0f));
    return whole(y) * (int)columns + whole(x);
}

// A point of the environment's picture.
typedef struct {
    mask texel;
    real x, y; // in it, from its upper left corner, in (0, 1)
} texel_point;

static inline uint texels_in(__global const float* scene)
{
    return (uint)scene[ENVIRONMENT_WIDTH] * (uint)scene[ENVIRONMENT_HEIGHT];
}

static inline mask cell_of(__global const float* scene, ureal x0)
{
    return AS_MASK(mul_hi(x0, (ureal)(texels_in(scene))));
}

// Drawn by two numbers of 32 bits.
static inline texel_point drawn_texel(__global const float* scene, __global const texel* texels, ureal x0,
                                      ureal x1)
{
    const mask cell = cell_of(scene, x0);
    ureal own, other;
    for (int lane = 0; lane < V; ++lane) {
        __global const texel* at = texels + ((int*)&cell)[lane];
        ((uint*)&own)[lane] = at->own;
        ((uint*)&other)[lane] = at->other;
    }
    const mask itself = x1 < own;
    texel_point p;
    p.texel = itself ? cell : AS_MASK(other);
    // What chose the cell is even within it, what chose its part within that.
    p.x = unit_interval(x0 * texels_in(scene));
    p.y = (TO_REAL(itself ? x1 : x1 - own) + 0.5f) / (itself ? TO_REAL(own) : TO_REAL(~own) + 1.0f);
    return p;
}

static inline vector towards_point(__global const float* scene, texel_point p)
{
    const float columns = scene[ENVIRONMENT_WIDTH];
    const float rows = scene[ENVIRONMENT_HEIGHT];
    // There is no division of vectors of integers: what rounding leaves is put right.
    mask row = whole(TO_REAL(p.texel) * (1.0f / columns));
    mask column = p.texel - row * (int)columns;
    const mask before = column < 0, after = column >= (int)columns;
    row = before ? row - 1 : after ? row + 1 : row;
    column = before ? column + (int)columns : after ? column - (int)columns : column;
    // Even by solid angle is even by height.
    real top, bottom, x, y;
    sine_of_turns(TO_REAL(row) * (0.5f / rows), &top);
    sine_of_turns((TO_REAL(row) + 1.0f) * (0.5f / rows), &bottom);
    const real z = clamp(top + p.y * (bottom - top), (real)(-1.0f), (real)(1.0f));
    const real r = sqrt((1.0f - z) * (1.0f + z));
    const real turn = 0.5f + scene[ENVIRONMENT_TURN] - (TO_REAL(column) + p.x) * (1.0f / columns);
    y = sine_of_turns(turn - floor(turn), &x);
    const vector to = {r * x, r * y, z};
    return to;
}

static inline __global const float* light_words(__global const float* scene, int k)
{
    return scene + SCENE_WORDS + (int)scene[SHAPES] * SHAPE_WORDS + k * LIGHT_WORDS;
}

// A direction to a light: what comes from it, over the density it was drawn with.
typedef struct {
    vector to;
    real distance;
    real density; // by solid angle; infinite where no other way finds the light, 0: nothing drawn
    real rgb[3];
} light_draw;

static inline real area_of(__global const float* light)
{
    const vector u = vector_of(light + LIGHT_HALF_U);
    const vector v = vector_of(light + LIGHT_HALF_V);
    return 4.0f * sqrt(dot3(u, u) * dot3(v, v));
}

// What a direction to the lights is drawn by.
typedef struct {
    real choice; // in (0, 1)
    ureal x, y;  // of 32 bits
    texel_point sky; // that x and y draw, where there is an environment
} light_numbers;

// Draws one light, in proportion to its LIGHT_CHOICE, and a direction to it.
static inline light_draw drawn_light(__global const float* scene, __global const texel* texels,
                                     vector at, light_numbers drawn)
{
    light_draw d;
    d.to.x = d.to.y = 0.0f;
    d.to.z = 1.0f;
    d.distance = INFINITY;
    d.density = 0.0f;
    d.rgb[0] = d.rgb[1] = d.rgb[2] = 0.0f;
    float passed = 0.0f;
    for (int k = 0; k < (int)scene[LIGHTS]; ++k) {
        __global const float* light = light_words(scene, k);
        const int kind = light[LIGHT_KIND];
        const float probability = light[LIGHT_CHOICE];
        const mask mine = drawn.choice > passed && drawn.choice <= passed + probability;
        passed += probability;
        if (!any_of(mine))
            continue;
        vector to = vector_of(light + LIGHT_AT);
        real distance = INFINITY;
        real density = INFINITY;
        real rgb[3];
        real scale = 1.0f / probability;
        if (kind == ENVIRONMENT) {
            real by_angle;
            to = towards_point(scene, drawn.sky);
            light_of(texels, drawn.sky.texel, rgb, &by_angle);
            density = probability * by_angle;
            scale = by_angle > 0.0f ? 1.0f / density : (real)(0.0f);
        } else {
            for (int ch = 0; ch < 3; ++ch)
                rgb[ch] = light[LIGHT_RGB + ch];
        }
        if (kind == RECTANGLE)
            to = plus(to, plus(scaled(vector_of(light + LIGHT_HALF_U), 2.0f * unit_interval(drawn.x) - 1.0f),
                               scaled(vector_of(light + LIGHT_HALF_V), 2.0f * unit_interval(drawn.y) - 1.0f)));
        if (kind == POINT || kind == RECTANGLE) {
            to = minus(to, at);
            const real d2 = fmax(dot3(to, to), (real)(1e-20f));
            distance = sqrt(d2);
            to = scaled(to, 1.0f / distance);
            if (kind == POINT)
                scale /= d2;
            else {
                const real facing = -dot3(to, vector_of(light + LIGHT_NORMAL));
                density = facing > 0.0f ? probability * d2 / (facing * area_of(light)) : (real)(0.0f);
                scale = density > 0.0f ? 1.0f / density : (real)(0.0f);
            }
        }
        d.to = chosen(mine, to, d.to);
        d.distance = mine ? distance : d.distance;
        d.density = mine ? density : d.density;
        for (int ch = 0; ch < 3; ++ch)
            d.rgb[ch] = mine ? rgb[ch] * scale : d.rgb[ch];
    }
    return d;
}

// What the lights send against a ray up to length t (infinite: the environment's too, from texel `sky`),
// times the weight of a direction drawn with density `own` against drawing lights; `camera`: the ray is
// the camera's, and `sky` is not known yet.
static inline void received(__global const float* scene, __global const texel* texels, vector at, vector to,
                            real t, real own, mask sky, bool camera, real* rgb)
{
    const mask beyond = isinf(t) != 0;
    const bool shown = scene[ENVIRONMENT_WIDTH] > 0.0f && (!camera || scene[SHOWS_ENVIRONMENT] > 0.0f);
    real weight = 1.0f;
    for (int ch = 0; ch < 3; ++ch)
        rgb[ch] = camera ? (real)(scene[BACKDROP + ch]) : (real)(0.0f);
    if (shown && any_of(beyond)) {
        real density;
        light_of(texels, camera ? texel_towards(scene, to) : sky, rgb, &density);
        weight = shared_weight(own, scene[ENVIRONMENT_CHOICE] * density);
    }
    for (int ch = 0; ch < 3; ++ch)
        rgb[ch] = beyond ? rgb[ch] * weight : (real)(0.0f);
    for (int k = 0; k < (int)scene[LIGHTS]; ++k) {
        __global const float* light = light_words(scene, k);
        if ((int)light[LIGHT_KIND] != RECTANGLE)
            continue;
        const vector normal = vector_of(light + LIGHT_NORMAL);
        const vector u = vector_of(light + LIGHT_HALF_U);
        const vector v = vector_of(light + LIGHT_HALF_V);
        const vector away = minus(at, vector_of(light + LIGHT_AT));
        const real facing = -dot3(to, normal);
        const real distance = dot3(away, normal) / facing;
        const vector on = plus(away, scaled(to, distance));
        const mask met = facing > 0.0f && distance > 0.0f && distance < t &&
                         fabs(dot3(on, u)) < dot3(u, u) && fabs(dot3(on, v)) < dot3(v, v);
        if (!any_of(met))
            continue;
        const real density = light[LIGHT_CHOICE] * distance * distance / (facing * area_of(light));
        const real weight = shared_weight(own, density);
        for (int ch = 0; ch < 3; ++ch)
            rgb[ch] += met ? light[LIGHT_RGB + ch] * weight : (real)(0.0f);
    }
}

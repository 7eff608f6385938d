// Lights of a scene (scene_words.h): what they send along a ray, and directions drawn to them.
//
// An environment is a picture, constant within each texel: rows are equal steps of the angle from z,
// from the top, columns equal steps of azimuth, from left to right clockwise seen from above; the middle
// looks along x. texels[i] is red, green, blue and the density by which a direction in it is drawn, by
// solid angle; aliases[i], of an alias table (Walker 1977, Vose 1991), is how often of 2^32 times cell i
// is itself, and which texel it is otherwise.

// The power heuristic with exponent 2 (Veach and Guibas 1995): the weight of a direction drawn with
// density `own` that would also have been drawn with density `other`. The two weights of a direction sum
// to 1. `own` may be infinite, a light that nothing else finds.
static inline real shared_weight(real own, real other)
{
    const real ratio = other / own;
    return own > 0.0f ? 1.0f / (1.0f + ratio * ratio) : (real)(0.0f);
}

static inline void texels_at(__global const float4* texels, mask index, real* rgb, real* density)
{
    for (int lane = 0; lane < V; ++lane) {
        const float4 texel = texels[((int*)&index)[lane]];
        ((float*)&rgb[0])[lane] = texel.x;
        ((float*)&rgb[1])[lane] = texel.y;
        ((float*)&rgb[2])[lane] = texel.z;
        ((float*)density)[lane] = texel.w;
    }
}

#if V == 1
static inline mask whole(real x) { return (int)x; }
#else
static inline mask whole(real x) { return JOIN(convert_int, V)(x); }
#endif

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

// A direction drawn to the environment by two numbers of 32 bits.
static inline vector towards_texel(__global const float* scene, __global const uint2* aliases, ureal x0,
                                   ureal x1, mask* texel)
{
    const uint columns = scene[ENVIRONMENT_WIDTH];
    const uint rows = scene[ENVIRONMENT_HEIGHT];
    const ureal cell = mul_hi(x0, (ureal)(columns * rows));
    const real u = unit_interval(x0 * (columns * rows)); // what chose the cell is even within it
    real v;
    for (int lane = 0; lane < V; ++lane) {
        const uint at = ((uint*)&cell)[lane];
        const uint2 alias = aliases[at];
        const uint x = ((uint*)&x1)[lane];
        const bool own = x < alias.x;
        ((int*)texel)[lane] = own ? at : alias.y;
        // As even within the part that x fell into.
        ((float*)&v)[lane] = own ? (x + 0.5f) / alias.x : (x - alias.x + 0.5f) / (4294967296.0f - alias.x);
    }
    const mask row = *texel / (int)columns;
    const mask column = *texel - row * (int)columns;
#if V == 1
    const real row_begin = row;
    const real column_begin = column;
#else
    const real row_begin = JOIN(convert_float, V)(row);
    const real column_begin = JOIN(convert_float, V)(column);
#endif
    // Even by solid angle is even by height.
    real top, bottom, x, y;
    sine_of_turns(row_begin * (0.5f / rows), &top);
    sine_of_turns((row_begin + 1.0f) * (0.5f / rows), &bottom);
    const real z = clamp(top + v * (bottom - top), (real)(-1.0f), (real)(1.0f));
    const real r = sqrt((1.0f - z) * (1.0f + z));
    const real turn = 0.5f + scene[ENVIRONMENT_TURN] - (column_begin + u) * (1.0f / columns);
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

// Draws one light, in proportion to its LIGHT_CHOICE, and a direction to it. `choice` in (0, 1), x0 and x1
// of 32 bits.
static inline light_draw drawn_light(__global const float* scene, __global const float4* texels,
                                     __global const uint2* aliases, vector at, real choice, ureal x0,
                                     ureal x1)
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
        const mask mine = choice > passed && choice <= passed + probability;
        passed += probability;
        if (!any_of(mine))
            continue;
        vector to = vector_of(light + LIGHT_AT);
        real distance = INFINITY;
        real density = INFINITY;
        real rgb[3];
        real scale = 1.0f / probability;
        if (kind == ENVIRONMENT) {
            mask texel;
            real by_angle;
            to = towards_texel(scene, aliases, x0, x1, &texel);
            texels_at(texels, texel, rgb, &by_angle);
            density = probability * by_angle;
            scale = by_angle > 0.0f ? 1.0f / density : (real)(0.0f);
        } else {
            for (int ch = 0; ch < 3; ++ch)
                rgb[ch] = light[LIGHT_RGB + ch];
        }
        if (kind == RECTANGLE)
            to = plus(to, plus(scaled(vector_of(light + LIGHT_HALF_U), 2.0f * unit_interval(x0) - 1.0f),
                               scaled(vector_of(light + LIGHT_HALF_V), 2.0f * unit_interval(x1) - 1.0f)));
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

// What the lights send against a ray up to length t (infinite: the environment's too), times the weight
// of a direction drawn with density `own` against drawing lights; `camera`: the ray is the camera's.
static inline void received(__global const float* scene, __global const float4* texels, vector at, vector to,
                            real t, real own, mask camera, real* rgb)
{
    rgb[0] = rgb[1] = rgb[2] = 0.0f;
    const mask beyond = isinf(t) != 0;
    if (any_of(beyond)) {
        const mask shown = beyond && (!camera || (mask)(scene[SHOWS_ENVIRONMENT] > 0.0f) != (mask)(0));
        for (int ch = 0; ch < 3; ++ch)
            rgb[ch] = beyond && camera && !shown ? (real)(scene[BACKDROP + ch]) : (real)(0.0f);
        if (scene[ENVIRONMENT_WIDTH] > 0.0f && any_of(shown)) {
            real texel[3], density;
            texels_at(texels, texel_towards(scene, to), texel, &density);
            const real weight = shared_weight(own, scene[ENVIRONMENT_CHOICE] * density);
            for (int ch = 0; ch < 3; ++ch)
                rgb[ch] = shown ? texel[ch] * weight : rgb[ch];
        }
    }
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

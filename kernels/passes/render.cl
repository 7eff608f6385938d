// Pictures of a scene by following paths from the camera, each vertex lit by directions drawn both to the
// lights and by the material's sampler (Veach and Guibas 1995). After passes/sample.cl and scene/*.cl.
//
// Sample i of a pixel is a function of the keys, pixel and i alone. Its numbers come from Owen-scrambled
// Sobol pairs, shuffled for each use (Burley 2020, "Practical hash-based Owen scrambling").

static inline uint hashed(uint x) // Wellons 2018, "lowbias32"
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

static inline ureal shuffled(ureal index, uint seed)
{
    return reversed_bits(scrambled_upwards(reversed_bits(index), seed));
}

// The numbers of one use, of 32 bits.
static inline void number_pair(ureal index, uint key, ureal* a, ureal* b)
{
    const ureal i = shuffled(index, hashed(key));
    *a = sobol_0(i, hashed(key + 1u));
    *b = sobol_1(i, hashed(key + 2u));
}

static inline ureal number(ureal index, uint key)
{
    return sobol_0(shuffled(index, hashed(key)), hashed(key + 1u));
}

static inline uint pixel_key_of(uint4 keys, uint pixel)
{
    return hashed(pixel ^ hashed(keys.x ^ hashed(keys.y ^ hashed(keys.z))));
}

// Keys of the uses: the film's, then those of each vertex.
#define USE_STEP 16u
enum { USE_LIGHT, USE_LIGHT_POINT, USE_COMPONENT, USE_DIRECTION, USES };
static inline uint key_of(uint pixel_key, int vertex, uint use)
{
    return pixel_key + (1u + vertex * USES + use) * USE_STEP;
}

typedef struct {
    vector at, to;    // to: unit
    real through[3];  // share of what comes along it that reaches the film
    real radiance[3]; // on the film so far
    real density;     // of `to`, as lights weigh it; infinite: nothing else finds what is there
    mask shape;       // it starts on, -1: none
    mask sky;         // the environment's texel along `to`, but for the camera's
    mask alive;
    real covered; // 1: the film shows a shape
} path;

static inline path path_begun(__global const float* scene, uint pixel, uint key, ureal index, mask wanted)
{
    ureal x0, x1;
    number_pair(index, key, &x0, &x1);
    const uint width = scene[FILM_WIDTH];
    const uint row = pixel / width;
    const real x = (pixel - row * width) + unit_interval(x0);
    const real y = row + unit_interval(x1);
    path p;
    p.at = vector_of(scene + CAMERA);
    p.to = unit(plus(vector_of(scene + CORNER),
                     plus(scaled(vector_of(scene + ACROSS), x), scaled(vector_of(scene + DOWN), y))));
    for (int ch = 0; ch < 3; ++ch) {
        p.through[ch] = 1.0f;
        p.radiance[ch] = 0.0f;
    }
    p.density = INFINITY;
    p.shape = -1;
    p.sky = 0;
    p.alive = wanted;
    p.covered = 0.0f;
    return p;
}

// Takes a path to what it meets: adds what lights send along it, and ends it where no shape is.
static inline meeting arrived(__global const float* scene, __global const texel* texels, bool camera,
                              path* p)
{
    const meeting m = first_met(scene, p->at, p->to, p->shape);
    real rgb[3];
    received(scene, texels, p->at, p->to, m.t, p->density, p->sky, camera, rgb);
    for (int ch = 0; ch < 3; ++ch)
        p->radiance[ch] += p->alive ? p->through[ch] * rgb[ch] : (real)(0.0f);
    p->alive = p->alive && m.shape >= 0;
    p->covered = p->alive ? (real)(1.0f) : p->covered;
    return m;
}

// P_j of the nearest entry of the table of albedos: near enough to draw components by.
static inline void nearest_probabilities(__global const float* table, __global const float* strengths,
                                         vector wo, real* p)
{
    int there = 0, alone = 0;
    for (int j = 0; j < BASIS; ++j)
        if (strengths[j] > 0.0f) {
            ++there;
            alone = j;
        }
    if (there <= 1) { // a metal, say
        for (int j = 0; j < BASIS; ++j)
            p[j] = j == alone ? 1.0f : 0.0f;
        return;
    }
    const mask row = whole(sqrt(clamp(wo.z, (real)(0.0f), (real)(1.0f))) * (HEIGHTS - 1) + 0.5f);
    const mask column = whole(atan2(fabs(wo.y), fabs(wo.x)) * ((AZIMUTHS - 1) * 2.0f / PI) + 0.5f);
    const mask at = row * AZIMUTHS + column;
    real sum = 0.0f;
    for (int j = 0; j < BASIS; ++j) {
        for (int lane = 0; lane < V; ++lane)
            ((float*)&p[j])[lane] = table[j * HEIGHTS * AZIMUTHS + ((int*)&at)[lane]];
        p[j] *= strengths[j];
        sum += p[j];
    }
    for (int j = 0; j < BASIS; ++j)
        p[j] = sum > 0.0f ? p[j] / sum : (real)(j == 0 ? 1.0f : 0.0f);
}

typedef struct {
    surface s;
    light_draw light;
    geometry to_light, to_next;   // as no model overflows at
    mask lit, goes_on;            // whether there is anything along them
    real light_weight[3];         // f of to_light times this is what it adds to the film
    real next_weight;             // f of to_next times this is the share that goes on
    real next_density;
    mask next_sky; // the environment's texel there
} vertex;

static inline real sampler_density(geometry q, PARAMETER_SPACE const float* theta, const real* probability,
                                   mask ground, int strategy)
{
    if (strategy == UNIFORM)
        return 0.5f / PI;
    real p[BASIS];
    component_densities(q, theta, p);
    real density = 0.0f;
    for (int j = 0; j < BASIS; ++j)
        density += probability[j] * fmin(p[j], (real)(1e30f));
    return ground ? cosine_density(q) : density;
}

static inline geometry drawn_direction(vector wo, PARAMETER_SPACE const float* theta,
                                       const real* probability, mask ground, int strategy, real choice,
                                       real u1, real u2)
{
    if (strategy == UNIFORM) {
        real cosine;
        const real sine = sine_of_turns(u2, &cosine);
        const real r = sqrt((1.0f - u1) * (1.0f + u1));
        const vector wi = {r * cosine, r * sine, u1};
        return between(wi, wo);
    }
    geometry q = component_sample(0, wo, theta, u1, u2);
    real passed = probability[0];
#pragma unroll
    for (int j = 1; j < BASIS; ++j) {
        const mask mine = choice > passed && !ground;
        if (any_of(mine))
            q = selected(mine, component_sample(j, wo, theta, u1, u2), q);
        passed += probability[j];
    }
    return q;
}

// What draws a vertex's direction to the lights. The environment's cells are fetched: found by the
// numbers alone, they are here when drawn_vertex() reads them if a path goes to its vertex in between.
static inline light_numbers numbers_to_light(__global const float* scene, __global const texel* texels,
                                             uint pixel_key, int number_of, ureal index)
{
    light_numbers drawn;
    drawn.choice = 0.5f;
    if ((int)scene[LIGHTS] > 1)
        drawn.choice = unit_interval(number(index, key_of(pixel_key, number_of, USE_LIGHT)));
    number_pair(index, key_of(pixel_key, number_of, USE_LIGHT_POINT), &drawn.x, &drawn.y);
    if (scene[ENVIRONMENT_WIDTH] > 0.0f)
        fetch_texels(texels, cell_of(scene, drawn.x));
    return drawn;
}

// Draws both directions of a path's vertex.
static inline vertex drawn_vertex(__global const float* scene, __global const texel* texels,
                                  PARAMETER_SPACE const float* theta, __global const float* table,
                                  __global const float* strengths, path* p, meeting m,
                                  light_numbers drawn, int strategy, uint pixel_key, int number_of,
                                  ureal index)
{
    const bool environment = scene[ENVIRONMENT_WIDTH] > 0.0f;
    if (environment) {
        drawn.sky = drawn_texel(scene, texels, drawn.x, drawn.y);
        fetch_texels(texels, drawn.sky.texel);
    }
    vertex v;
    v.s = surface_met(scene, p->at, p->to, m);
    vector wo = to_local(v.s, scaled(p->to, -1.0f));
    p->alive = p->alive && wo.z > 1e-5f;
    const vector up = {(real)(0.0f), (real)(0.0f), (real)(1.0f)};
    wo = chosen(p->alive, wo, up);
    real probability[BASIS];
    nearest_probabilities(table, strengths, wo, probability);

    v.light = drawn_light(scene, texels, v.s.at, drawn);
    geometry q = between(to_local(v.s, v.light.to), wo);
    v.lit = p->alive && q.wi_z > 0.0f && v.light.density > 0.0f;
    if ((int)scene[SHAPES] > 1)
        v.lit = v.lit && !(first_met(scene, v.s.at, v.light.to, m.shape).t < v.light.distance);
    q = above_horizon(q, v.lit);
    v.to_light = q;
    const mask alone = isinf(v.light.density) != 0;
    real other = sampler_density(q, theta, probability, v.s.ground, strategy);
    other = strategy == BOTH ? other : (real)(strategy == LIGHTS_ALONE ? 0.0f : INFINITY);
    const real shared = shared_weight(v.light.density, alone ? (real)(0.0f) : other) * q.wi_z;
    for (int ch = 0; ch < 3; ++ch)
        v.light_weight[ch] = v.lit ? p->through[ch] * v.light.rgb[ch] * shared : (real)(0.0f);

    ureal x0, x1;
    number_pair(index, key_of(pixel_key, number_of, USE_DIRECTION), &x0, &x1);
    const real component = unit_interval(number(index, key_of(pixel_key, number_of, USE_COMPONENT)));
    q = drawn_direction(wo, theta, probability, v.s.ground, strategy, component, unit_interval(x0),
                        unit_interval(x1));
    v.goes_on = p->alive && q.wi_z > 0.0f && q.c > 0.0f;
    q = above_horizon(q, v.goes_on);
    v.to_next = q;
    v.next_sky = 0;
    if (environment) {
        v.next_sky = texel_towards(scene, from_local(v.s, wi_of(q)));
        fetch_texels(texels, v.next_sky);
    }
    v.next_density = sampler_density(q, theta, probability, v.s.ground, strategy);
    v.goes_on = v.goes_on && v.next_density > 0.0f;
    v.next_weight = v.goes_on ? q.wi_z / v.next_density : (real)(0.0f);
    return v;
}

// Adds what the lights send by a vertex whose BRDF is f, and turns the path to where it goes on.
static inline void followed(path* p, const vertex* v, mask shape, const real* f_light, const real* f_next,
                            int strategy)
{
    for (int ch = 0; ch < 3; ++ch) {
        p->radiance[ch] += v->light_weight[ch] * f_light[ch];
        p->through[ch] *= v->next_weight * f_next[ch];
    }
    p->alive = v->goes_on;
    p->at = v->s.at;
    p->to = from_local(v->s, wi_of(v->to_next));
    p->shape = shape;
    p->sky = v->next_sky;
    p->density = strategy == BOTH ? v->next_density : (real)(strategy == LIGHTS_ALONE ? 0.0f : INFINITY);
}

// f in red, green, blue.
static inline void response(geometry q, PARAMETER_SPACE const float* theta,
                            __global const float* coefficients, mask ground, __global const float* scene,
                            real* f)
{
    real plane[PLANES + 1], b[BASIS], d[ENTRIES + 1];
    material_prepare(q, plane);
    material_basis(plane, theta, b, d);
    for (int ch = 0; ch < 3; ++ch) {
        real sum = 0.0f;
        for (int j = 0; j < BASIS; ++j)
            sum += coefficients[ch * BASIS + j] * fmin(b[j], (real)(1e30f));
        f[ch] = ground ? (real)(scene[GROUND + ch] * (1.0f / PI)) : fmin(sum, (real)(1e30f));
    }
}

// Means over `count` samples of each of `pixels` pixels from `first` on: out[ch * pixels + i], the fourth
// the share that shapes cover. keys: seed and batch.
__kernel void render(__global const float* scene, __global const texel* texels,
                     PARAMETER_SPACE const float* theta, __global const float* table,
                     __global const float* strengths, __global const float* coefficients, uint4 keys,
                     int strategy, int bounces, uint count, uint first, uint pixels, __global float* out)
{
    FOR_EACH_OF_RUN(i, pixels)
    {
        const uint pixel = first + i;
        const uint pixel_key = pixel_key_of(keys, pixel);
        float sum[4] = {0.0f, 0.0f, 0.0f, 0.0f};
        for (uint k = 0; k < count; k += V) {
            const ureal index = k + lane_numbers();
            path p = path_begun(scene, pixel, pixel_key, index, index < count);
            for (int n = 0; n <= bounces + 1; ++n) {
                light_numbers drawn;
                if (n <= bounces)
                    drawn = numbers_to_light(scene, texels, pixel_key, n, index);
                const meeting m = arrived(scene, texels, n == 0, &p);
                if (n > bounces || !any_of(p.alive))
                    break;
                const vertex v = drawn_vertex(scene, texels, theta, table, strengths, &p, m, drawn,
                                              strategy, pixel_key, n, index);
                real f_light[3], f_next[3];
                response(v.to_light, theta, coefficients, v.s.ground, scene, f_light);
                response(v.to_next, theta, coefficients, v.s.ground, scene, f_next);
                followed(&p, &v, m.shape, f_light, f_next, strategy);
            }
            for (int ch = 0; ch < 3; ++ch)
                sum[ch] += lanes_sum(p.radiance[ch]);
            sum[3] += lanes_sum(p.covered);
        }
        for (int ch = 0; ch < 4; ++ch)
            out[ch * (ulong)pixels + i] = sum[ch] / count;
    }
}

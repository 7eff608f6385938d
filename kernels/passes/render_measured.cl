// The same paths as render.cl's, a vertex of all at once, for BRDFs that are evaluated elsewhere: meet()
// writes pairs of directions, follow() takes the values there. Path i is sample i % groups * V + lane of
// pixel first + i / groups, groups = ceil(count / V). State as planes of scene_words.h.

static inline vector read_vector(__global const real* planes, uint stride, uint i)
{
    const vector v = {planes[i], planes[i + (ulong)stride], planes[i + 2 * (ulong)stride]};
    return v;
}

static inline void write_vector(__global real* planes, uint stride, uint i, vector v)
{
    planes[i] = v.x;
    planes[i + (ulong)stride] = v.y;
    planes[i + 2 * (ulong)stride] = v.z;
}

static inline path read_path(__global const real* planes, uint stride, uint i)
{
    path p;
    p.at = read_vector(planes + PATH_AT * (ulong)stride, stride, i);
    p.to = read_vector(planes + PATH_TO * (ulong)stride, stride, i);
    for (int ch = 0; ch < 3; ++ch) {
        p.through[ch] = planes[i + (PATH_THROUGH + ch) * (ulong)stride];
        p.radiance[ch] = planes[i + (PATH_RADIANCE + ch) * (ulong)stride];
    }
    p.density = planes[i + PATH_DENSITY * (ulong)stride];
    p.shape = whole(planes[i + PATH_SHAPE * (ulong)stride]);
    p.sky = 0;
    p.alive = planes[i + PATH_ALIVE * (ulong)stride] > 0.0f;
    p.covered = planes[i + PATH_COVERED * (ulong)stride];
    return p;
}

static inline void write_path(__global real* planes, uint stride, uint i, path p)
{
    write_vector(planes + PATH_AT * (ulong)stride, stride, i, p.at);
    write_vector(planes + PATH_TO * (ulong)stride, stride, i, p.to);
    for (int ch = 0; ch < 3; ++ch) {
        planes[i + (PATH_THROUGH + ch) * (ulong)stride] = p.through[ch];
        planes[i + (PATH_RADIANCE + ch) * (ulong)stride] = p.radiance[ch];
    }
    planes[i + PATH_DENSITY * (ulong)stride] = p.density;
#if V == 1
    planes[i + PATH_SHAPE * (ulong)stride] = p.shape;
#else
    planes[i + PATH_SHAPE * (ulong)stride] = JOIN(convert_float, V)(p.shape);
#endif
    planes[i + PATH_ALIVE * (ulong)stride] = p.alive ? (real)(1.0f) : (real)(0.0f);
    planes[i + PATH_COVERED * (ulong)stride] = p.covered;
}

__kernel void begin_paths(__global const float* scene, uint4 keys, uint count, uint groups, uint first,
                          uint paths, __global real* planes)
{
    FOR_EACH_OF_RUN(i, paths)
    {
        const uint pixel = first + i / groups;
        const ureal index = i % groups * V + lane_numbers();
        write_path(planes, paths, i,
                   path_begun(scene, pixel, pixel_key_of(keys, pixel), index, index < count));
    }
}

// One half of the pairs: what is not wanted is below the horizon, where every BRDF is 0 at once.
static inline void write_pair(__global real* pairs, uint pairs_stride, uint i, geometry q, mask wanted)
{
    real plane[DIRECTION_PLANES];
    q.wi_z = wanted ? q.wi_z : (real)(-1.0f);
    write_geometry(q, plane);
    for (int k = 0; k < DIRECTION_PLANES; ++k)
        pairs[i + k * (ulong)pairs_stride] = plane[k];
}

// Takes every path to its vertex number n and, unless it is the last one, draws its directions: pairs
// [0, paths) to the light, [paths, 2 paths) to where it goes on.
__kernel void meet(__global const float* scene, __global const texel* texels,
                   PARAMETER_SPACE const float* theta, __global const float* table,
                   __global const float* strengths, uint4 keys, int strategy, int n, int last, uint groups,
                   uint first, uint paths, __global real* planes, __global real* pairs,
                   __global real* vertices)
{
    FOR_EACH_OF_RUN(i, paths)
    {
        path p = read_path(planes, paths, i);
        if (n > 0 && scene[ENVIRONMENT_WIDTH] > 0.0f)
            p.sky = texel_towards(scene, p.to);
        const meeting m = arrived(scene, texels, n == 0, &p);
        if (!last) {
            const uint pixel_key = pixel_key_of(keys, first + i / groups);
            const ureal index = i % groups * V + lane_numbers();
            const light_numbers drawn = numbers_to_light(scene, texels, pixel_key, n, index);
            const vertex v = drawn_vertex(scene, texels, theta, table, strengths, &p, m, drawn, strategy,
                                          pixel_key, n, index);
            write_pair(pairs, 2 * paths, i, v.to_light, v.lit);
            write_pair(pairs, 2 * paths, paths + i, v.to_next, v.goes_on);
            for (int ch = 0; ch < 3; ++ch)
                vertices[i + (VERTEX_LIGHT_SCALE + ch) * (ulong)paths] = v.light_weight[ch];
            vertices[i + VERTEX_NEXT_SCALE * (ulong)paths] = v.next_weight;
            vertices[i + VERTEX_GROUND * (ulong)paths] = v.s.ground ? (real)(1.0f) : (real)(0.0f);
            const real one[3] = {1.0f, 1.0f, 1.0f};
            path next = p;
            followed(&next, &v, m.shape, one, one, strategy);
            for (int ch = 0; ch < 3; ++ch) { // these wait for the BRDF
                next.through[ch] = p.through[ch];
                next.radiance[ch] = p.radiance[ch];
            }
            p = next;
        }
        write_path(planes, paths, i, p);
    }
}

// Goes on from the vertices by the BRDF's values at the pairs, values[ch][pair].
__kernel void follow(__global const float* scene, __global const real* vertices, __global const real* values,
                     uint paths, __global real* planes)
{
    FOR_EACH_OF_RUN(i, paths)
    {
        const mask ground = vertices[i + VERTEX_GROUND * (ulong)paths] > 0.0f;
        const real next = vertices[i + VERTEX_NEXT_SCALE * (ulong)paths];
        for (int ch = 0; ch < 3; ++ch) {
            const real of_ground = scene[GROUND + ch] * (1.0f / PI);
            const real f_light = ground ? of_ground : values[i + ch * 2 * (ulong)paths];
            const real f_next = ground ? of_ground : values[i + (ch * 2 + 1) * (ulong)paths];
            planes[i + (PATH_RADIANCE + ch) * (ulong)paths] +=
                vertices[i + (VERTEX_LIGHT_SCALE + ch) * (ulong)paths] * f_light;
            planes[i + (PATH_THROUGH + ch) * (ulong)paths] *= next * f_next;
        }
    }
}

// Means of each pixel's paths, as render() writes them.
__kernel void gather(__global const real* planes, uint count, uint groups, uint pixels, __global float* out)
{
    FOR_EACH_OF_RUN(i, pixels)
    {
        const ulong paths = (ulong)pixels * groups;
        for (int ch = 0; ch < 4; ++ch) {
            float sum = 0.0f;
            for (uint g = 0; g < groups; ++g)
                sum += lanes_sum(planes[i * groups + g + (ch < 3 ? PATH_RADIANCE + ch : PATH_COVERED) * paths]);
            out[ch * (ulong)pixels + i] = sum / count;
        }
    }
}

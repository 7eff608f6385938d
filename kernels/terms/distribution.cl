// Distributions of microfacet normals p(h) by solid angle, over the whole sphere and not normalised
// (Ashikhmin, Premoze, Shirley 2000, section 6), from the table that describes one together with what
// the generator computed for it (table_words.h): the sum over its parts of
//     amplitude shape(h in the part's frame) image(h)
// with the shapes Gaussian (Eq. 34), velvet (Eq. 35) or tabulated.

static inline vector in_frame(PARAMETER_SPACE const float* m, vector h)
{
    const vector l = {m[0] * h.x + m[1] * h.y + m[2] * h.z, m[3] * h.x + m[4] * h.y + m[5] * h.z,
                          m[6] * h.x + m[7] * h.y + m[8] * h.z};
    return l;
}

static inline vector out_of_frame(PARAMETER_SPACE const float* m, vector l)
{
    const vector h = {m[0] * l.x + m[3] * l.y + m[6] * l.z, m[1] * l.x + m[4] * l.y + m[7] * l.z,
                      m[2] * l.x + m[5] * l.y + m[8] * l.z};
    return h;
}

// The last of `count` ascending values that is not above x, at most the last but one.
static inline int interval_of(PARAMETER_SPACE const float* values, int count, float x)
{
    int low = 0;
    int high = count - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (values[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return low;
}

// Bilinear over the polar angles and azimuths whose nodes stand ahead of the values; azimuths go
// round, beyond the first and last polar angle the value stays.
static inline float tabulated_at(PARAMETER_SPACE const float* values, int rows, int columns, float theta,
                                 float phi)
{
    PARAMETER_SPACE const float* thetas = values;
    PARAMETER_SPACE const float* phis = values + rows;
    PARAMETER_SPACE const float* p = values + rows + columns;
    const int i = interval_of(thetas, rows, theta);
    const float s = clamp((theta - thetas[i]) / (thetas[i + 1] - thetas[i]), 0.0f, 1.0f);
    PARAMETER_SPACE const float* low = p + i * columns;
    PARAMETER_SPACE const float* high = low + columns;
    if (columns == 1)
        return mix(low[0], high[0], s);
    phi += phi < phis[0] ? 2.0f * PI : 0.0f;
    const int last = phi >= phis[columns - 1];
    const int k = last ? columns - 1 : interval_of(phis, columns, phi);
    const int next = last ? 0 : k + 1;
    const float width = last ? phis[0] + 2.0f * PI - phis[k] : phis[next] - phis[k];
    const float t = clamp((phi - phis[k]) / width, 0.0f, 1.0f);
    return mix(mix(low[k], low[next], t), mix(high[k], high[next], t), s);
}

// Bilinear between the pixels' centres, row 0 at the top. The image lies on the disk of (h.x, h.y), its
// centre at the pole and y upwards, or has azimuths from left to right and polar angles downwards;
// beyond its borders the outermost pixels go on.
static inline float image_at(PARAMETER_SPACE const float* pixels, int width, int height, float extent,
                             float x, float y, float z)
{
    const bool disk = extent > 0.0f;
    const float turn = atan2(y, x) * (0.5f / PI);
    float u = disk ? 0.5f + 0.5f * x / extent : turn < 0.0f ? turn + 1.0f : turn;
    float v = disk ? 0.5f - 0.5f * y / extent : atan2(sqrt(x * x + y * y), z) * (2.0f / PI);
    u = u * width - 0.5f;
    v = clamp(v * height - 0.5f, 0.0f, height - 1.0f);
    u = disk ? clamp(u, 0.0f, width - 1.0f) : u;
    const int i = (int)floor(u);
    const int k = min((int)v, max(height - 2, 0));
    const int left = disk ? min(i, width - 1) : (i + width) % width;
    const int right = disk ? min(i + 1, width - 1) : (i + 1) % width;
    PARAMETER_SPACE const float* upper = pixels + k * width;
    PARAMETER_SPACE const float* lower = pixels + min(k + 1, height - 1) * width;
    const float s = u - i;
    return mix(mix(upper[left], upper[right], s), mix(lower[left], lower[right], s), v - k);
}

// One part's share of p(h).
static inline real part_of_distribution(PARAMETER_SPACE const float* table,
                                        PARAMETER_SPACE const float* part, vector h)
{
    const int kind = (int)part[KIND];
    const vector l = in_frame(part + FRAME, h);
    real p = 0.0f;
    if (kind == TABULATED) {
        const real theta = atan2(sqrt(l.x * l.x + l.y * l.y), l.z);
        const real phi = atan2(l.y, l.x);
        for (int lane = 0; lane < V; ++lane)
            ((float*)&p)[lane] =
                tabulated_at(table + (int)part[IMAGE], (int)part[IMAGE_HEIGHT], (int)part[IMAGE_WIDTH],
                             ((const float*)&theta)[lane], ((const float*)&phi)[lane]);
        return part[AMPLITUDE] * p;
    }
    // 0 below the part's own horizon.
    const mask above = l.z > 0.0f;
    const real z = above ? l.z : (real)(1.0f);
    const real x2 = squared(l.x / z);
    const real y2 = squared(l.y / z);
    const real exponent = kind == VELVET ? part[INVERSE_X2] / fmax(x2 + y2, (real)(1e-30f))
                                         : part[INVERSE_X2] * x2 + part[INVERSE_Y2] * y2;
    p = above ? part[AMPLITUDE] * exp(-exponent) : (real)(0.0f);
    if (part[IMAGE] > 0.0f) {
        real m = 0.0f;
        for (int lane = 0; lane < V; ++lane)
            ((float*)&m)[lane] =
                image_at(table + (int)part[IMAGE], (int)part[IMAGE_WIDTH], (int)part[IMAGE_HEIGHT],
                         part[IMAGE_EXTENT], ((const float*)&h.x)[lane], ((const float*)&h.y)[lane],
                         ((const float*)&h.z)[lane]);
        p *= m;
    }
    return p;
}

static inline real distribution(PARAMETER_SPACE const float* table, vector h)
{
    real p = 0.0f;
    for (int k = 0; k < (int)table[PARTS]; ++k)
        p += part_of_distribution(table, table + (int)table[FIRST_PART] + k * PART_WORDS, h);
    return p;
}

// The polar angle where a part ends at azimuth (x, y) of its frame.
static inline float greatest_theta(PARAMETER_SPACE const float* part, float x, float y)
{
    if ((int)part[KIND] != GAUSSIAN)
        return part[GREATEST_THETA];
    const float inverse = (part[INVERSE_X2] * x * x + part[INVERSE_Y2] * y * y) / (x * x + y * y);
    return inverse > 0.0f ? atan2(REACH, sqrt(inverse)) : 0.5f * PI;
}

// d psi / d phi at azimuth (x, y) of the part's frame.
static inline float azimuth_slope(PARAMETER_SPACE const float* part, float x, float y)
{
    const float u = x / part[STRETCH_X];
    const float v = y / part[STRETCH_Y];
    return (x * x + y * y) / ((u * u + v * v) * part[STRETCH_X] * part[STRETCH_Y]);
}

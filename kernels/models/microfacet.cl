// Ashikhmin, Premoze, Shirley 2000, the BRDF generated from a distribution of normals, Eq. 26:
//     g = p(h) <h.n> F / (4 g(wi) g(wo))
// or with correlated shadowing, Eq. 14: <h.n> / (g(wi) g(wo)) becomes P(wi, wo) / (iz oz <h.n>).
// theta: f0

static inline void microfacet_prepare(geometry q, real* plane)
{
    plane[0] = q.wi_x;
    plane[1] = q.wi_y;
    plane[2] = q.wi_z;
    plane[3] = q.wo_x;
    plane[4] = q.wo_y;
    plane[5] = q.wo_z;
    plane[6] = q.h_x;
    plane[7] = q.h_y;
    plane[8] = q.h_z;
    plane[9] = q.c;
}

static inline real microfacet(const real* plane, PARAMETER_SPACE const float* theta,
                              PARAMETER_SPACE const float* table, real* d)
{
    const geometry q = geometry_of(plane);
    const vector wi = {q.wi_x, q.wi_y, q.wi_z};
    const vector wo = wo_of(q);
    const vector h = {q.h_x, q.h_y, q.h_z};
    const real s = 0.25f * distribution(table, h) *
                   shadowing(table, wi, wo, visible_area(table, wi), visible_area(table, wo),
                             CORRELATED > 0.0f);
    return schlick_times(schlick_p5(q), theta[0], s, d);
}

// Half vectors of p(h); where many normals are steep (STEEP, their share), half vectors often reflect
// below the horizon, and that share of directions is drawn by their cosine instead.

// A half vector of p(h) as its cells hold it: a part, a column of cells, a cell, then uniformly by
// azimuth psi and height in the cell.
static inline void drawn_half(PARAMETER_SPACE const float* table, float u1, float u2, float* h)
{
    PARAMETER_SPACE const float* part = table + (int)FIRST_PART;
    for (int k = 1; k < (int)PARTS && u1 >= PROBABILITY; ++k) {
        u1 -= PROBABILITY;
        part += PART_WORDS;
    }
    u1 = fmin(u1 / PROBABILITY, 0.99999994f);
    const int rows = (int)CELL_ROWS;
    const int columns = (int)CELL_COLUMNS;
    PARAMETER_SPACE const float* marginal = table + (int)MARGINAL;
    const int k = interval_of(marginal, columns + 1, u1);
    PARAMETER_SPACE const float* conditional = table + (int)CONDITIONAL + k * (rows + 1);
    const int i = interval_of(conditional, rows + 1, u2);
    const float along = (u1 - marginal[k]) / fmax(marginal[k + 1] - marginal[k], 1e-30f);
    const float up = (u2 - conditional[i]) / fmax(conditional[i + 1] - conditional[i], 1e-30f);
    const float psi = (k + clamp(along, 0.0f, 1.0f)) / columns * (2.0f * PI);
    const float x = STRETCH_X * cos(psi);
    const float y = STRETCH_Y * sin(psi);
    const float range = greatest_theta(part, x, y) - LEAST_THETA;
    PARAMETER_SPACE const float* edges = table + (int)CELL_EDGES;
    const float low = sin(0.5f * (LEAST_THETA + range * edges[i]));
    const float high = sin(0.5f * (LEAST_THETA + range * edges[i + 1]));
    const float half_sine2 = mix(low * low, high * high, clamp(up, 0.0f, 1.0f));
    const float sine = 2.0f * sqrt(half_sine2 * (1.0f - half_sine2));
    const float r = sqrt(x * x + y * y);
    const float l[3] = {sine * x / r, sine * y / r, 1.0f - 2.0f * half_sine2};
    for (int a = 0; a < 3; ++a)
        h[a] = FRAME[a] * l[0] + FRAME[3 + a] * l[1] + FRAME[6 + a] * l[2];
}

// The density of drawn_half by solid angle.
static inline float half_density(PARAMETER_SPACE const float* table, float hx, float hy, float hz)
{
    float density = 0.0f;
    for (int n = 0; n < (int)PARTS; ++n) {
        PARAMETER_SPACE const float* part = table + (int)FIRST_PART + n * PART_WORDS;
        PARAMETER_SPACE const float* m = FRAME;
        const float x = m[0] * hx + m[1] * hy + m[2] * hz;
        const float y = m[3] * hx + m[4] * hy + m[5] * hz;
        const float z = m[6] * hx + m[7] * hy + m[8] * hz;
        const float r = sqrt(x * x + y * y);
        const float ax = r > 0.0f ? x / r : 1.0f;
        const float ay = r > 0.0f ? y / r : 0.0f;
        const float range = greatest_theta(part, ax, ay) - LEAST_THETA;
        const float share = (atan2(r, z) - LEAST_THETA) / range;
        if (share < 0.0f || share >= 1.0f)
            continue;
        const int rows = (int)CELL_ROWS;
        const int columns = (int)CELL_COLUMNS;
        const float turn = atan2(ay * STRETCH_X, ax * STRETCH_Y) * (0.5f / PI);
        const int k = min((int)((turn < 0.0f ? turn + 1.0f : turn) * columns), columns - 1);
        PARAMETER_SPACE const float* edges = table + (int)CELL_EDGES;
        const int i = interval_of(edges, rows + 1, share);
        PARAMETER_SPACE const float* marginal = table + (int)MARGINAL + k;
        PARAMETER_SPACE const float* conditional = table + (int)CONDITIONAL + k * (rows + 1) + i;
        const float low = sin(0.5f * (LEAST_THETA + range * edges[i]));
        const float high = sin(0.5f * (LEAST_THETA + range * edges[i + 1]));
        density += PROBABILITY * (marginal[1] - marginal[0]) * (conditional[1] - conditional[0]) *
                   azimuth_slope(part, ax, ay) * columns /
                   (4.0f * PI * (high - low) * (high + low));
    }
    return density;
}

static inline geometry microfacet_sample(vector wo, PARAMETER_SPACE const float* theta,
                                         PARAMETER_SPACE const float* table, real u1, real u2)
{
    const mask blind = u1 < STEEP;
    const geometry other = cosine_sample(wo, fmin(u1 / fmax(STEEP, 1e-6f), (real)(0.99999994f)), u2);
    u1 = clamp((u1 - STEEP) / (1.0f - STEEP), (real)(0.0f), (real)(0.99999994f));
    vector h;
    for (int lane = 0; lane < V; ++lane) {
        float one[3];
        drawn_half(table, ((const float*)&u1)[lane], ((const float*)&u2)[lane], one);
        ((float*)&h.x)[lane] = one[0];
        ((float*)&h.y)[lane] = one[1];
        ((float*)&h.z)[lane] = one[2];
    }
    geometry q = reflected(wo, unit(h));
    // A half vector below the horizon or turned away gives nothing.
    q.wi_z = q.c > 0.0f && h.z > 0.0f ? q.wi_z : -fabs(q.wi_z);
    return selected(blind, other, q);
}

static inline real microfacet_density(geometry q, PARAMETER_SPACE const float* theta,
                                      PARAMETER_SPACE const float* table)
{
    real p = 0.0f;
    for (int lane = 0; lane < V; ++lane)
        ((float*)&p)[lane] = half_density(table, ((const float*)&q.h_x)[lane],
                                          ((const float*)&q.h_y)[lane], ((const float*)&q.h_z)[lane]);
    return (1.0f - STEEP) * p / (4.0f * q.c) + STEEP * cosine_density(q);
}

// Ashikhmin, Premoze, Shirley 2000, the BRDF generated from a distribution of normals, Eq. 26:
//     g = p(h) <h.n> F / (4 g(wi) g(wo))
// or with correlated shadowing, Eq. 14: <h.n> / (g(wi) g(wo)) becomes P(wi, wo) / (iz oz <h.n>). p, g(k)
// and <h.n> of terms/distribution.cl and grid.cl.
// theta: f0

enum { MICROFACET_PLANES = DIRECTION_PLANES };

static inline void microfacet_prepare(geometry q, real* plane) { write_geometry(q, plane); }

static inline real microfacet(const real* plane, PARAMETER_SPACE const float* theta,
                              PARAMETER_SPACE const float* table, real* d)
{
    const geometry q = geometry_of(plane);
    const vector wi = wi_of(q);
    const vector wo = wo_of(q);
    const vector h = h_of(q);
    const real s = 0.25f * distribution(table, h) *
                   shadowing(table, wi, wo, visible_area(table, wi), visible_area(table, wo),
                             table[CORRELATED] > 0.0f);
    return schlick_times(schlick_p5(q), theta[0], s, d);
}

// Half vectors of p(h); where many normals are steep (STEEP, their share), half vectors often reflect
// below the horizon, and that share of directions is drawn by their cosine instead.

// A half vector of p(h) as its cells hold it: a part, a column of cells, a cell, then uniformly by
// azimuth psi and height in the cell.
static inline void drawn_half(PARAMETER_SPACE const float* table, float u1, float u2, float* h)
{
    PARAMETER_SPACE const float* part = table + (int)table[FIRST_PART];
    for (int k = 1; k < (int)table[PARTS] && u1 >= part[PROBABILITY]; ++k) {
        u1 -= part[PROBABILITY];
        part += PART_WORDS;
    }
    u1 = fmin(u1 / part[PROBABILITY], 0.99999994f);
    const int rows = (int)part[CELL_ROWS];
    const int columns = (int)part[CELL_COLUMNS];
    PARAMETER_SPACE const float* marginal = table + (int)part[MARGINAL];
    const int k = interval_of(marginal, columns + 1, u1);
    PARAMETER_SPACE const float* conditional = table + (int)part[CONDITIONAL] + k * (rows + 1);
    const int i = interval_of(conditional, rows + 1, u2);
    const float along = (u1 - marginal[k]) / fmax(marginal[k + 1] - marginal[k], 1e-30f);
    const float up = (u2 - conditional[i]) / fmax(conditional[i + 1] - conditional[i], 1e-30f);
    const float psi = (k + clamp(along, 0.0f, 1.0f)) / columns * (2.0f * PI);
    const float x = part[STRETCH_X] * cos(psi);
    const float y = part[STRETCH_Y] * sin(psi);
    const float range = greatest_theta(part, x, y) - part[LEAST_THETA];
    PARAMETER_SPACE const float* edges = table + (int)part[CELL_EDGES];
    const float low = sin(0.5f * (part[LEAST_THETA] + range * edges[i]));
    const float high = sin(0.5f * (part[LEAST_THETA] + range * edges[i + 1]));
    const float half_sine2 = mix(low * low, high * high, clamp(up, 0.0f, 1.0f));
    const float sine = 2.0f * sqrt(half_sine2 * (1.0f - half_sine2));
    const float r = sqrt(x * x + y * y);
    const float l[3] = {sine * x / r, sine * y / r, 1.0f - 2.0f * half_sine2};
    PARAMETER_SPACE const float* m = part + FRAME;
    for (int a = 0; a < 3; ++a)
        h[a] = m[a] * l[0] + m[3 + a] * l[1] + m[6 + a] * l[2];
}

// The density of drawn_half by solid angle.
static inline float half_density(PARAMETER_SPACE const float* table, float hx, float hy, float hz)
{
    float density = 0.0f;
    for (int n = 0; n < (int)table[PARTS]; ++n) {
        PARAMETER_SPACE const float* part = table + (int)table[FIRST_PART] + n * PART_WORDS;
        PARAMETER_SPACE const float* m = part + FRAME;
        const float x = m[0] * hx + m[1] * hy + m[2] * hz;
        const float y = m[3] * hx + m[4] * hy + m[5] * hz;
        const float z = m[6] * hx + m[7] * hy + m[8] * hz;
        const float r = sqrt(x * x + y * y);
        const float ax = r > 0.0f ? x / r : 1.0f;
        const float ay = r > 0.0f ? y / r : 0.0f;
        const float range = greatest_theta(part, ax, ay) - part[LEAST_THETA];
        const float share = (atan2(r, z) - part[LEAST_THETA]) / range;
        if (share < 0.0f || share >= 1.0f)
            continue;
        const int rows = (int)part[CELL_ROWS];
        const int columns = (int)part[CELL_COLUMNS];
        const float turn = atan2(ay * part[STRETCH_X], ax * part[STRETCH_Y]) * (0.5f / PI);
        const int k = min((int)((turn < 0.0f ? turn + 1.0f : turn) * columns), columns - 1);
        PARAMETER_SPACE const float* edges = table + (int)part[CELL_EDGES];
        const int i = interval_of(edges, rows + 1, share);
        PARAMETER_SPACE const float* marginal = table + (int)part[MARGINAL] + k;
        PARAMETER_SPACE const float* conditional = table + (int)part[CONDITIONAL] + k * (rows + 1) + i;
        const float low = sin(0.5f * (part[LEAST_THETA] + range * edges[i]));
        const float high = sin(0.5f * (part[LEAST_THETA] + range * edges[i + 1]));
        density += part[PROBABILITY] * (marginal[1] - marginal[0]) * (conditional[1] - conditional[0]) *
                   azimuth_slope(part, ax, ay) * columns /
                   (4.0f * PI * (high - low) * (high + low));
    }
    return density;
}

static inline geometry microfacet_sample(vector wo, PARAMETER_SPACE const float* theta,
                                         PARAMETER_SPACE const float* table, real u1, real u2)
{
    const mask blind = u1 < table[STEEP];
    const geometry other = cosine_sample(wo, fmin(u1 / fmax(table[STEEP], 1e-6f), (real)(0.99999994f)), u2);
    u1 = clamp((u1 - table[STEEP]) / (1.0f - table[STEEP]), (real)(0.0f), (real)(0.99999994f));
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
    return (1.0f - table[STEEP]) * p / (4.0f * q.c) + table[STEEP] * cosine_density(q);
}

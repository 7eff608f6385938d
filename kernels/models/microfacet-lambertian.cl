// Ashikhmin, Premoze, Shirley 2000, Eq. 33 with Lambertian facets, beta = 1 / pi, on an isotropic
// distribution:
//     g = P(wi, wo) / (iz oz <h.n>) integral of beta (wi.h)+ (wo.h)+ p(h) dw
// the integral from a table over both elevations (in the rows of kernels/terms/grid.cl) and the azimuth
// between the directions, in equal steps over [0, pi].
// theta: none

enum { MICROFACET_LAMBERTIAN_PLANES = WO_Z + 1 };

static inline void microfacet_lambertian_prepare(geometry q, real* plane) { write_directions(q, plane); }

// Cubic in all three coordinates. Azimuths are mirrored at both ends.
static inline float facets_at(PARAMETER_SPACE const float* plane, int rows, int columns, float row_i,
                              float row_o, float column)
{
    const int i = clamp((int)row_i - 1, 0, rows - 4);
    const int o = clamp((int)row_o - 1, 0, rows - 4);
    const int k = min((int)column, columns - 2);
    float wi[4], wo[4], w[4];
    cubic_weights(row_i - i, wi);
    cubic_weights(row_o - o, wo);
    cubic_weights(column - k + 1.0f, w);
    float sum = 0.0f;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
            PARAMETER_SPACE const float* at = plane + ((i + a) * rows + o + b) * columns;
            float along = 0.0f;
            for (int n = 0; n < 4; ++n) {
                const int m = abs(k - 1 + n);
                along += w[n] * at[m < columns ? m : 2 * (columns - 1) - m];
            }
            sum += wi[a] * wo[b] * along;
        }
    return sum;
}

static inline real microfacet_lambertian(const real* plane, PARAMETER_SPACE const float* theta,
                                         PARAMETER_SPACE const float* table, real* d)
{
    const vector wi = wi_at(plane);
    const vector wo = wo_at(plane);
    const real scale = (table[FACET_ROWS] - 1.0f) / (table[GRID_ROWS] - 1.0f);
    const real row_i = grid_row(table, wi) * scale;
    const real row_o = grid_row(table, wo) * scale;
    const real phi = atan2(fabs(wi.x * wo.y - wi.y * wo.x), wi.x * wo.x + wi.y * wo.y);
    const real column = phi * ((table[FACET_COLUMNS] - 1.0f) / PI);
    real t = 0.0f;
    for (int lane = 0; lane < V; ++lane)
        ((float*)&t)[lane] =
            facets_at(table + (int)table[FACETS], (int)table[FACET_ROWS], (int)table[FACET_COLUMNS],
                      ((const float*)&row_i)[lane], ((const float*)&row_o)[lane],
                      ((const float*)&column)[lane]);
    return (1.0f / PI) * fmax(t, (real)(0.0f)) *
           shadowing(table, wi, wo, visible_area(table, wi), visible_area(table, wo),
                     table[CORRELATED] > 0.0f);
}

static inline geometry microfacet_lambertian_sample(vector wo, PARAMETER_SPACE const float* theta,
                                                    PARAMETER_SPACE const float* table, real u1, real u2)
{
    return cosine_sample(wo, u1, u2);
}

static inline real microfacet_lambertian_density(geometry q, PARAMETER_SPACE const float* theta,
                                                 PARAMETER_SPACE const float* table)
{
    return cosine_density(q);
}

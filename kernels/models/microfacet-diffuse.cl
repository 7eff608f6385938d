// Ashikhmin, Premoze, Shirley 2000, Eq. 28 and 30, what the generated lobe does not reflect:
//     diffuse = c (1 - R(wi)) (1 - R(wo)),   R = (1 - f0) R_0 + f0 R_1
// for metals max(0, f0 - R) in place of 1 - R, times f0. R above 1 counts as 1.
// theta: f0 of the first lobe; table: the first lobe's

enum { MICROFACET_DIFFUSE_PLANES = WO_Z + 1 };

static inline void microfacet_diffuse_prepare(geometry q, real* plane) { write_directions(q, plane); }

// What the lobe leaves of light from k.
static inline real unreflected(PARAMETER_SPACE const float* table, float f0, vector k)
{
    const real row = grid_row(table, k);
    const real column = grid_column(table, k);
    const real r_0 = plane_at(table, table[REFLECTANCE_0], row, column);
    const real r_1 = plane_at(table, table[REFLECTANCE_1], row, column);
    return fmax((table[METAL] > 0.0f ? f0 : 1.0f) - (1.0f - f0) * r_0 - f0 * r_1, (real)(0.0f));
}

static inline real microfacet_diffuse(const real* plane, PARAMETER_SPACE const float* theta,
                                      PARAMETER_SPACE const float* table, real* d)
{
    const vector wi = wi_at(plane);
    const vector wo = wo_at(plane);
    d[0] = 0.0f; // models with tables are not fitted
    return (table[DIFFUSE_SCALE] * (table[METAL] > 0.0f ? theta[0] : 1.0f)) *
           unreflected(table, theta[0], wi) * unreflected(table, theta[0], wo);
}

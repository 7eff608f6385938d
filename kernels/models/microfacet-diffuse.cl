// Ashikhmin, Premoze, Shirley 2000, Eq. 28 and 30, what the generated lobe does not reflect:
//     diffuse = c (1 - R(wi)) (1 - R(wo)),   R = (1 - f0) R_0 + f0 R_1
// for metals max(0, f0 - R) in place of 1 - R, times f0. R above 1 counts as 1.
// theta: f0 of the first lobe; table: the first lobe's

static inline void microfacet_diffuse_prepare(geometry q, real* plane)
{
    plane[0] = q.wi_x;
    plane[1] = q.wi_y;
    plane[2] = q.wi_z;
    plane[3] = q.wo_x;
    plane[4] = q.wo_y;
    plane[5] = q.wo_z;
}

// What the lobe leaves of light from k.
static inline real unreflected(PARAMETER_SPACE const float* table, float f0, vector k)
{
    const real row = grid_row(table, k);
    const real column = grid_column(table, k);
    const real r_0 = plane_at(table, REFLECTANCE_0, row, column);
    const real r_1 = plane_at(table, REFLECTANCE_1, row, column);
    return fmax((METAL > 0.0f ? f0 : 1.0f) - (1.0f - f0) * r_0 - f0 * r_1, (real)(0.0f));
}

static inline real microfacet_diffuse(const real* plane, PARAMETER_SPACE const float* theta,
                                      PARAMETER_SPACE const float* table, real* d)
{
    const vector wi = {plane[0], plane[1], plane[2]};
    const vector wo = {plane[3], plane[4], plane[5]};
    d[0] = 0.0f; // models with tables are not fitted
    return (DIFFUSE_SCALE * (METAL > 0.0f ? theta[0] : 1.0f)) * unreflected(table, theta[0], wi) *
           unreflected(table, theta[0], wo);
}

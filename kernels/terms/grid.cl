// The grid of directions that tables of the generator are over, and cubic interpolation in it.
// Rows: elevations e = a sinh(b r), r from 0 (the horizon) to 1 (the normal), so that they are finer at
// grazing, where sharp distributions change g within their width a. Columns: azimuths over the sector
// that the symmetry leaves, tan phi = stretch tan psi with psi in equal steps. A plane has one column
// more before the sector's first and two after its last, so that interpolation need not know the
// symmetry; an isotropic one has a single column.

static inline real grid_row(PARAMETER_SPACE const float* table, vector k)
{
    const real t = atan2(k.z, sqrt(k.x * k.x + k.y * k.y)) / table[ELEVATION_SCALE];
    return log(t + sqrt(t * t + 1.0f)) * ((table[GRID_ROWS] - 1.0f) / table[ELEVATION_END]);
}

static inline real grid_column(PARAMETER_SPACE const float* table, vector k)
{
    if (table[GRID_COLUMNS] == 1.0f)
        return 0.0f;
    const int sector = (int)table[GRID_SECTOR];
    const real x = table[AZIMUTH_STRETCH] * (sector == QUARTER_TURN ? fabs(k.x) : k.x);
    const real psi = atan2(sector == WHOLE_TURN ? k.y : fabs(k.y), x);
    if (sector == WHOLE_TURN)
        return (psi < 0.0f ? psi + 2.0f * PI : psi) * (table[GRID_COLUMNS] * 0.5f / PI);
    return psi * ((table[GRID_COLUMNS] - 1.0f) * sector * 0.5f / PI);
}

// Lagrange's weights of the nodes 0 to 3 at x.
static inline void cubic_weights(float x, float* w)
{
    const float a = x - 1.0f;
    const float b = x - 2.0f;
    const float c = x - 3.0f;
    w[0] = a * b * c * (-1.0f / 6.0f);
    w[1] = x * b * c * 0.5f;
    w[2] = x * a * c * -0.5f;
    w[3] = x * a * b * (1.0f / 6.0f);
}

static inline float cubic_at(PARAMETER_SPACE const float* plane, int rows, int columns, float row,
                             float column)
{
    const int i = clamp((int)row - 1, 0, rows - 4);
    float w[4];
    cubic_weights(row - i, w);
    if (columns == 1)
        return w[0] * plane[i] + w[1] * plane[i + 1] + w[2] * plane[i + 2] + w[3] * plane[i + 3];
    const int stride = columns + COLUMNS_BEYOND;
    const int k = min((int)column, columns - 1);
    float v[4];
    cubic_weights(column - k + 1.0f, v);
    float sum = 0.0f;
    for (int r = 0; r < 4; ++r) {
        PARAMETER_SPACE const float* at = plane + (i + r) * stride + k + COLUMNS_BEFORE - 1;
        sum += w[r] * (v[0] * at[0] + v[1] * at[1] + v[2] * at[2] + v[3] * at[3]);
    }
    return sum;
}

static inline real plane_at(PARAMETER_SPACE const float* table, float offset, real row, real column)
{
    real value = 0.0f;
    for (int lane = 0; lane < V; ++lane)
        ((float*)&value)[lane] =
            cubic_at(table + (int)offset, (int)table[GRID_ROWS], (int)table[GRID_COLUMNS],
                     ((const float*)&row)[lane], ((const float*)&column)[lane]);
    return value;
}

// Linear between the nodes: for planes fine enough.
static inline float linear_at(PARAMETER_SPACE const float* plane, int rows, int columns, float row,
                              float column)
{
    const int i = clamp((int)row, 0, rows - 2);
    const float s = row - i;
    if (columns == 1)
        return mix(plane[i], plane[i + 1], s);
    const int stride = columns + COLUMNS_BEYOND;
    const int k = min((int)column, columns - 1);
    PARAMETER_SPACE const float* at = plane + i * stride + k + COLUMNS_BEFORE;
    return mix(mix(at[0], at[1], column - k), mix(at[stride], at[stride + 1], column - k), s);
}

static inline real area_from(PARAMETER_SPACE const float* table, vector k, real behind)
{
    if (table[LEANS] > 0.0f)
        return exp(behind);
    const real g = table[MEAN_X] * k.x + table[MEAN_Y] * k.y + table[MEAN_Z] * k.z + behind;
    return fmax(g, (real)(LEAST_AREA * table[MEAN_HEIGHT]));
}

// g(k) = k.<h> + g(-k): what is seen from behind is small but near the horizon, and so is the error of
// interpolating it. Normals that lean to one side leave g small on the other: then log(g) is interpolated.
static inline real visible_area(PARAMETER_SPACE const float* table, vector k)
{
    return area_from(table, k, plane_at(table, table[BEHIND], grid_row(table, k), grid_column(table, k)));
}

// The same, linear between the nodes.
static inline real visible_area_linear(PARAMETER_SPACE const float* table, vector k)
{
    const real row = grid_row(table, k);
    const real column = grid_column(table, k);
    real behind = 0.0f;
    for (int lane = 0; lane < V; ++lane)
        ((float*)&behind)[lane] =
            linear_at(table + (int)table[BEHIND], (int)table[GRID_ROWS], (int)table[GRID_COLUMNS],
                      ((const float*)&row)[lane], ((const float*)&column)[lane]);
    return area_from(table, k, behind);
}

// t of Eq. 14, from the angle between the projections of wi and wo: 1 where they are the same.
static inline real azimuth_correlation(vector wi, vector wo)
{
    const real phi = atan2(wi.x * wo.y - wi.y * wo.x, wi.x * wo.x + wi.y * wo.y) * (12.0f / PI);
    return exp(-0.5f * phi * phi);
}

// The visibility P(wi, wo) / (iz oz <h.n>), <h.n> / (g(wi) g(wo)) where it is not correlated:
// Eq. 25 and 14.
static inline real shadowing(PARAMETER_SPACE const float* table, vector wi, vector wo, real g_i, real g_o,
                             bool correlated)
{
    const real independent = table[MEAN_HEIGHT] / (g_i * g_o);
    if (!correlated)
        return independent;
    const real t = azimuth_correlation(wi, wo);
    // min(P(wi), P(wo)) / (iz oz <h.n>)
    const real common = fmin(1.0f / (wo.z * g_i), 1.0f / (wi.z * g_o));
    return (1.0f - t) * independent + t * common;
}

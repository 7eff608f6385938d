// Values of a material at directions. After the generated text (see host/device/program.cpp) that
// defines BASIS, ENTRIES, PLANES and
//     material_prepare(geometry, plane)      the planes of every model
//     material_basis(plane, theta, b, d)     b[0] diffuse, b[1..] lobes; derivative entries d[]

static inline geometry read_geometry(__global const real* directions, uint stride, uint i)
{
    real p[DIRECTION_PLANES];
    for (int k = 0; k < DIRECTION_PLANES; ++k)
        p[k] = directions[i + k * stride];
    return geometry_of(p);
}

// A geometry that no model overflows at, for lanes below the horizon.
static inline geometry above_horizon(geometry q, mask above)
{
    q.wi_z = above ? q.wi_z : (real)(1.0f);
    q.wo_z = above ? q.wo_z : (real)(1.0f);
    q.h_x = above ? q.h_x : (real)(0.0f);
    q.h_y = above ? q.h_y : (real)(0.0f);
    q.h_z = above ? q.h_z : (real)(1.0f);
    q.c = above ? q.c : (real)(1.0f);
    return q;
}

// A BRDF value: 0 below the horizon, finite above it.
static inline real finite_above(real f, mask above) { return above ? fmin(f, (real)(FLT_MAX)) : (real)(0.0f); }

// Basis values and derivative entries at pair i of the directions; whether it is above the horizon.
static inline mask basis_at(__global const real* directions, uint count, uint i,
                            __constant const float* theta, real* b, real* d)
{
    const geometry q = read_geometry(directions, count, i);
    const mask above = q.wi_z > 0.0f && q.wo_z > 0.0f;
    real plane[PLANES + 1];
    material_prepare(above_horizon(q, above), plane);
    material_basis(plane, theta, b, d);
    return above;
}

// values[channel][i] = sum over j of coefficients[channel][j] b_j; `count` in units of V.
__kernel void evaluate(__global const real* directions, uint count, __constant const float* theta,
                       __global const float* coefficients, int channels, __global real* values)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    real b[BASIS], d[ENTRIES + 1];
    const mask above = basis_at(directions, count, i, theta, b, d);
    for (int ch = 0; ch < channels; ++ch) {
        real f = 0.0f;
        for (int j = 0; j < BASIS; ++j)
            // 0 * inf must be 0: an unused term adds nothing.
            f += coefficients[ch * BASIS + j] * fmin(b[j], (real)(FLT_MAX));
        values[(ulong)ch * count + i] = finite_above(f, above);
    }
}

// out[j][i]: b_j, then the derivative entries; for checking models one by one.
__kernel void evaluate_basis(__global const real* directions, uint count,
                             __constant const float* theta, __global real* out)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    real b[BASIS], d[ENTRIES + 1];
    const mask above = basis_at(directions, count, i, theta, b, d);
    for (int j = 0; j < BASIS; ++j)
        out[(ulong)j * count + i] = finite_above(b[j], above);
    for (int e = 0; e < ENTRIES; ++e)
        out[(ulong)(BASIS + e) * count + i] = above ? d[e] : (real)(0.0f);
}

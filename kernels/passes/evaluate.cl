// Values of a material at directions. After the generated text (see host/model/program.cpp) that
// defines BASIS, ENTRIES, PLANES and
//     material_prepare(geometry, plane)      the planes of every model
//     material_basis(plane, theta, b, d)     b[0] diffuse, b[1..] lobes; derivative entries d[]

// Basis values and derivative entries at pair i of the directions; whether it is above the horizon.
static inline mask basis_at(__global const real* directions, uint count, uint i,
                            PARAMETER_SPACE const float* theta, real* b, real* d)
{
    const geometry q = read_geometry(directions, count, i);
    const mask above = q.wi_z > 0.0f && q.wo_z > 0.0f;
    real plane[PLANES + 1];
    material_prepare(above_horizon(q, above), plane);
    material_basis(plane, theta, b, d);
    return above;
}

// values[channel][i] = sum over j of coefficients[channel][j] b_j; `count` in units of V.
__kernel void evaluate(__global const real* directions, uint count, PARAMETER_SPACE const float* theta,
                       __global const float* coefficients, int channels, __global real* values)
{
    FOR_EACH_OF_RUN(i, count)
    {
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
}

// out[j][i]: b_j, then the derivative entries; for checking models one by one.
__kernel void evaluate_basis(__global const real* directions, uint count,
                             PARAMETER_SPACE const float* theta, __global real* out)
{
    FOR_EACH_OF_RUN(i, count)
    {
        real b[BASIS], d[ENTRIES + 1];
        const mask above = basis_at(directions, count, i, theta, b, d);
        for (int j = 0; j < BASIS; ++j)
            out[(ulong)j * count + i] = finite_above(b[j], above);
        for (int e = 0; e < ENTRIES; ++e)
            out[(ulong)(BASIS + e) * count + i] = above ? d[e] : (real)(0.0f);
    }
}

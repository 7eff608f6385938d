// Inner products of all pairs of rows of samples, the only place where the global search touches
// samples: everything else it does is small linear algebra on these. A group multiplies T = GRAM_TILE rows
// with T: group (tj, ti, g) writes rows ti * T.. by tj * T.. (tj <= ti) over its block at
// out[((ti * tiles + tj) * blocks + g) * T^2].
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
gram(__global const real* rows, uint stride, __global float* out)
{
    __local float scratch[LS];
    const uint tj = get_group_id(0);
    const uint ti = get_group_id(1);
    __global const real* row = rows + (ulong)ti * GRAM_TILE * stride;
    __global const real* column = rows + (ulong)tj * GRAM_TILE * stride;
    real sum[GRAM_TILE * GRAM_TILE];
#pragma unroll
    for (int k = 0; k < GRAM_TILE * GRAM_TILE; ++k)
        sum[k] = 0.0f;
    FOR_EACH_OF_BLOCK(i, get_group_id(2), tj <= ti ? stride : 0)
    {
        real x[GRAM_TILE], y[GRAM_TILE];
#pragma unroll
        for (int k = 0; k < GRAM_TILE; ++k) {
            x[k] = row[k * stride + i];
            y[k] = column[k * stride + i];
        }
#pragma unroll
        for (int k = 0; k < GRAM_TILE; ++k)
#pragma unroll
            for (int l = 0; l < GRAM_TILE; ++l)
                sum[k * GRAM_TILE + l] += x[k] * y[l];
    }
    write_group_sums(sum, GRAM_TILE * GRAM_TILE, scratch,
                     out + ((ulong)(ti * get_num_groups(0) + tj) * get_num_groups(2) +
                            get_group_id(2)) * GRAM_TILE * GRAM_TILE);
}

// What a device does at most: reading memory, exp and log. Nothing else is in the way here.

// The sum of a buffer, a block a group.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
read_memory(__global const real* data, __global float* out)
{
    __local float scratch[LS];
    const uint begin = get_group_id(0) * BLOCK;
    real sum = 0.0f;
    for (uint i = begin + get_local_id(0); i < begin + BLOCK; i += LS)
        sum += data[i];
    write_group_sums(&sum, 1, scratch, out + get_group_id(0));
}

// `rounds` times CHAINS calls a lane of exp(-x) or log(x + 3), in chains that do not wait for each other and
// stay near a fixed point.
static inline void calls(int rounds, bool logarithms, __local float* scratch, __global float* out)
{
    real x[CHAINS];
#pragma unroll
    for (int k = 0; k < CHAINS; ++k)
        x[k] = 0.1f * (float)(k + 1) + 0.001f * (float)get_local_id(0);
    for (int r = 0; r < rounds; ++r)
#pragma unroll
        for (int k = 0; k < CHAINS; ++k)
            x[k] = logarithms ? log(x[k] + 3.0f) : exp(-x[k]);
#pragma unroll
    for (int k = 1; k < CHAINS; ++k)
        x[0] += x[k];
    write_group_sums(x, 1, scratch, out + get_group_id(0));
}

__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void exp_calls(int rounds, __global float* out)
{
    __local float scratch[LS];
    calls(rounds, false, scratch, out);
}

__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void log_calls(int rounds, __global float* out)
{
    __local float scratch[LS];
    calls(rounds, true, scratch, out);
}

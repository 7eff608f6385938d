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

// `rounds` times CHAINS calls a lane, in chains that do not wait for each other and stay near a fixed
// point.
#define CHAINS 8
#define DEFINE_CALLS(NAME, STEP)                                                                   \
    __kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void NAME(int rounds,                 \
                                                                       __global float* out)        \
    {                                                                                              \
        __local float scratch[LS];                                                                 \
        real x[CHAINS];                                                                            \
        _Pragma("unroll") for (int k = 0; k < CHAINS; ++k)                                         \
            x[k] = 0.1f * (float)(k + 1) + 0.001f * (float)get_local_id(0);                        \
        for (int r = 0; r < rounds; ++r)                                                           \
            _Pragma("unroll") for (int k = 0; k < CHAINS; ++k) x[k] = STEP(x[k]);                  \
        _Pragma("unroll") for (int k = 1; k < CHAINS; ++k) x[0] += x[k];                           \
        write_group_sums(x, 1, scratch, out + get_group_id(0));                                    \
    }

#define EXP_STEP(x) exp(-(x))
#define LOG_STEP(x) log((x) + 3.0f)
DEFINE_CALLS(exp_calls, EXP_STEP)
DEFINE_CALLS(log_calls, LOG_STEP)

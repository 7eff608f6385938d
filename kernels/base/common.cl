// Written once for every device. The host defines, before this text:
//   V    samples a work-item handles at once (16 on a CPU, 1 on a GPU)
//   LS   work-items a group (1 on a CPU)
//   RUN  vectors a work-item handles one after the other where there is nothing to sum (1 on a GPU)
//   BLOCK  vectors a group sums, some for each of its items
// Samples lie in planes of `real`, padded to a vector for each item of a group; the padding has weight 0.

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

#if V == 1
typedef float real;
typedef int mask;
#else
typedef JOIN(float, V) real;
typedef JOIN(int, V) mask;
#endif

// Where the parameters of a material's lobes are: tables among them (TABLES) are too large for constant
// memory.
#ifdef TABLES
#define PARAMETER_SPACE __global
#else
#define PARAMETER_SPACE __constant
#endif

// For kernels whose work-items do not need each other: i is every vector below `count` of the item's run.
#define FOR_EACH_OF_RUN(i, count)                                                                  \
    for (uint i = get_global_id(0) * RUN, end_ = min(i + RUN, (uint)(count)); i < end_; ++i)

// For kernels that sum over groups: i is every vector of the item's in a block, below `count`.
#define FOR_EACH_OF_BLOCK(i, block, count)                                                         \
    for (uint begin_ = (uint)(block) * BLOCK, i = begin_ + get_local_id(0),                        \
              end_ = min(begin_ + BLOCK, (uint)(count));                                           \
         i < end_; i += LS)

// Whether any lane of a comparison holds.
#if V == 1
static inline bool any_of(mask x) { return x != 0; }
#else
static inline bool any_of(mask x) { return any(x); }
#endif

#define PI 3.14159265358979f

#if V == 1
static inline float lanes_sum(real x) { return x; }
#elif V == 2
static inline float lanes_sum(real x) { return x.s0 + x.s1; }
#elif V == 4
static inline float lanes_sum(real x) { return (x.s0 + x.s1) + (x.s2 + x.s3); }
#elif V == 8
static inline float lanes_sum(real x)
{
    const float4 y = x.lo + x.hi;
    return (y.s0 + y.s1) + (y.s2 + y.s3);
}
#else
static inline float lanes_sum(real x)
{
    const float8 y = x.lo + x.hi;
    const float4 z = y.lo + y.hi;
    return (z.s0 + z.s1) + (z.s2 + z.s3);
}
#endif

// Adds each of `count` private sums over the group and writes them to out[0..count).
// Every work-item must get here: there are barriers inside.
static inline void write_group_sums(const real* sum, int count, __local float* scratch, __global float* out)
{
#if LS == 1
    for (int k = 0; k < count; ++k)
        out[k] = lanes_sum(sum[k]);
#else
    const int item = get_local_id(0);
    for (int k = 0; k < count; ++k) {
        scratch[item] = lanes_sum(sum[k]);
        barrier(CLK_LOCAL_MEM_FENCE);
        for (int half_size = LS / 2; half_size > 0; half_size /= 2) {
            if (item < half_size)
                scratch[item] += scratch[item + half_size];
            barrier(CLK_LOCAL_MEM_FENCE);
        }
        if (item == 0)
            out[k] = scratch[0];
        barrier(CLK_LOCAL_MEM_FENCE);
    }
#endif
}

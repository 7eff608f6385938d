// The passes over measured samples that fitting needs: this one, sums.cl, residual.cl, loss.cl, metrics.cl
// and search.cl. After the generated text (see evaluate.cl),
// which also defines
//     CHANNELS     channels of the file
//     CHUNK        channels a sums pass handles at once; values are padded to whole chunks
//     ENTRY_BASIS  {...}: the basis function that each derivative entry belongs to
// Samples: planes of the models, values y, weights W = w iz^2; `stride` reals a plane.
// A group writes its sums in float32 (a block is small enough for 1e-6); the host adds the groups in
// order in float64, so that results repeat bit for bit.

// Plane p and channel ch of sample i: on a CPU a sample's planes lie together, and its channels by
// chunks, so that few prefetchers follow few streams; on a GPU neighbouring items read neighbouring samples.
#if LS == 1
#define PLANE_AT(stride, i, p) ((ulong)(i) * PLANES + (p))
#define VALUE_AT(stride, i, ch) VALUE_IN_CHUNK((ulong)(stride), i, ch, CHUNK)
#else
#define PLANE_AT(stride, i, p) ((ulong)(p) * (stride) + (i))
#define VALUE_AT(stride, i, ch) VALUE_IN_PLANE((ulong)(stride), i, ch)
#endif

__constant const int entry_basis[ENTRIES + 1] = ENTRY_BASIS;

// Fills the models' planes for the samples that `index` picks from the directions of a file.
__kernel void prepare(__global const float* directions, uint pairs, __global const uint* index,
                      __global real* planes, uint stride)
{
    FOR_EACH_OF_RUN(i, stride)
    {
        real direction[DIRECTION_PLANES];
        for (int lane = 0; lane < V; ++lane) {
            const uint k = index[i * V + lane];
            for (int p = 0; p < DIRECTION_PLANES; ++p)
                ((float*)direction)[p * V + lane] = directions[(ulong)p * pairs + k];
        }
        real plane[PLANES + 1];
        material_prepare(geometry_of(direction), plane);
        for (int p = 0; p < PLANES; ++p)
            planes[PLANE_AT(stride, i, p)] = plane[p];
    }
}

static inline void read_planes(__global const real* planes, uint stride, uint i, real* plane)
{
    for (int p = 0; p < PLANES; ++p)
        plane[p] = planes[PLANE_AT(stride, i, p)];
}

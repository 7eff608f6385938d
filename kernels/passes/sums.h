// How many sums the passes of fitting write, for `basis` basis functions, `entries` derivative
// entries and chunks of `chunk` channels: fit/objective.cpp counts with what the kernels count
// with.
#define TRIANGLE(n) ((n) * ((n) + 1) / 2)

// sums.cl: W b_j b_k (k <= j) | W r_ch b_j | W r_ch^2 ...
#define BASIS_SUMS(basis, chunk) (TRIANGLE(basis) + (chunk) * (basis) + 1)
// ... | for each entry: W d_e b_j, W d_e r_ch ...
#define ENTRY_SUMS(basis, chunk) ((basis) + (chunk))
#define GRADIENT_SUMS(basis, chunk, entries)                                                       \
    (BASIS_SUMS(basis, chunk) + (entries)*ENTRY_SUMS(basis, chunk))
// ... | W d_e d_f (f <= e)
#define NORMAL_SUMS(basis, chunk, entries)                                                         \
    (GRADIENT_SUMS(basis, chunk, entries) + TRIANGLE(entries))

// residual.cl: the squared error | for each entry
#define RESIDUAL_SUMS(entries) (1 + (entries))

// loss.cl: for each entry | for each channel of a chunk: loss | by each coefficient | half the
// Hessian
#define LARGEST_LOSS_CHUNK 4
#define CHANNEL_SUMS(basis) (1 + (basis) + TRIANGLE(basis))
#define LOSS_SUMS(basis, chunk, entries) ((entries) + (chunk)*CHANNEL_SUMS(basis))

// metrics.cl: the squared residuals of each metric, in the order of fit/metric.hpp
enum metric_sum { NGAN_SUM, L2_SUM, LOG_SUM, CBRT_SUM, METRIC_SUMS };

// search.cl: of a candidate's shape s and, where its model has F, of its slope t by f0
enum shape_sum { SHAPE_SS, SHAPE_SB, SHAPE_ST, SHAPE_TT, SHAPE_TB, SHAPE_FIRST_Y };
// W s^2 | W s b_0 [| W s t | W t^2 | W t b_0 | W t y_ch] | W s y_ch
#define SHAPE_SUMS(fresnel, chunk) ((fresnel) ? SHAPE_FIRST_Y + 2 * (chunk) : SHAPE_ST + (chunk))

#pragma once

#include "host/device/device.hpp"
#include "host/model/structure.hpp"

namespace brdfit {

/// Builds the kernels of passes/evaluate.cl and, unless it has tables, passes/sums.cl, loss.cl and
/// search.cl for a structure and files of `channels` channels, handled `chunk` at once. Throws
/// InputError with the build log, whose lines carry the kernel file's name.
cl::Program build_program(const Device& device, const Structure& structure, int channels,
                          int chunk);
/// Builds passes/sample.cl for a structure, which must have the anisotropic form. Throws like
/// build_program.
cl::Program build_sample_program(const Device& device, const Structure& structure);
/// Builds passes/albedo.cl for a structure, which must have the anisotropic form. Throws like
/// build_program.
cl::Program build_albedo_program(const Device& device, const Structure& structure);

} // namespace brdfit

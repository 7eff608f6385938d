#pragma once

#include "host/device/device.hpp"
#include "host/model/structure.hpp"

// A program is text for one structure: macros, the kernel files that it needs, and between the
// models' files and those of the passes what says which models to run. For a kurt lobe over
// lambert, isotropic, that is (shortened)
//
//     #define BASIS 2                          // lambert, kurt
//     #define ENTRIES 3                        // derivatives, by f0, m and alpha
//     #define PLANES 4                         // of what depends on the directions alone
//     #define ENTRY_BASIS {1, 1, 1, 0}         // the basis function of each derivative, and a 0
//     static inline void material_prepare(geometry q, real* plane)
//     {
//         lambert_prepare(q, plane + 0);
//         kurt_prepare(q, plane + 0);
//     }
//     static inline void material_basis(const real* plane, ... theta, real* b, real* d)
//     {
//         b[0] = lambert(plane + 0, theta, d + 3);
//         b[1] = kurt(plane + 0, theta + 0, d + 0);
//     }
//
// and for drawing and albedos component_sample and component_densities, which do the same with
// kurt_sample and kurt_density. A lobe whose frame is turned (Model::turns) is run through
// kurt_turned and so on, which turn the directions first.

namespace brdfit {

/// Builds the kernels of passes/evaluate.cl and, unless it has tables, those of passes/prepare.cl,
/// sums.cl, residual.cl, loss.cl, metrics.cl and search.cl for a structure and files of `channels`
/// channels, handled `chunk` at once. Throws InputError with the build log, whose lines carry the
/// kernel file's name.
cl::Program build_program(const Device& device, const Structure& structure, int channels,
                          int chunk);
/// Builds passes/sample.cl for a structure, which must have the anisotropic form. Throws like
/// build_program.
cl::Program build_sample_program(const Device& device, const Structure& structure);
/// Builds passes/render.cl and render_measured.cl, with sample.cl and what they need of scene/, for
/// a structure, which must have the anisotropic form. Throws like build_program.
cl::Program build_render_program(const Device& device, const Structure& structure);
/// Builds passes/albedo.cl for a structure, which must have the anisotropic form. Throws like
/// build_program.
cl::Program build_albedo_program(const Device& device, const Structure& structure);

} // namespace brdfit

#pragma once

#include "host/albedo/material.hpp"
#include "host/measured/samples.hpp"
#include "host/progress.hpp"

namespace brdfit {

/// Whether the samples lie on a grid that has a value for every viewer (MERL's), so that
/// measured_albedo takes viewers of the caller's choice.
bool on_grid(const Samples& samples);

/// The albedo of what was measured; what was not counts as 0, and how much of the projected
/// hemisphere was measured is stated beside it.
///
/// MERL's grid: for each viewer, the bins of theta_h one by one, points spread over each bin's half
/// vectors (shifted Fibonacci lattices), looked up in the bins they fall into, until the spread of
/// independent estimates is within the tolerance or a bin has 10946 points. Errors are those of the
/// integration; the hemispherical albedo is a Gauss-Legendre sum over viewers.
///
/// Scattered samples: one row for each light direction of the file (`grid` is not asked), the
/// integral over its viewers, which for reciprocal materials is the albedo of that direction as a
/// viewer; where the file has fewer viewers than light directions, one row for each viewer, the
/// integral over its light directions, to which what follows applies likewise. Every viewer of the
/// hemisphere takes the value measured nearest to it, up to as far as a sample's fourth nearest
/// neighbour is; what is farther was not measured. In isotropic data mirrored viewers are the same.
/// The error is the difference from an interpolation of the three
/// nearest values. The hemispherical albedo is interpolated linearly in sin^2 theta between the
/// rows, and leaves out what lies below the least and above the largest theta.
///
/// Throws InputError where no direction that would be a row has at least eight others.
Albedo measured_albedo(const Samples& samples, const AlbedoGrid& grid, double tolerance,
                       const ProgressFunction& progress = {});

} // namespace brdfit

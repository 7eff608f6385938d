#pragma once

#include "host/evaluate/tabulate.hpp"
#include "host/progress.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

/// The matrix of a BRDF over the 145 patches of the Klems basis, as daylighting programs take it:
/// Klems, "A New Method for Predicting the Solar Heat Gain of Complex Fenestration Systems", 1994;
/// written as LBNL WINDOW's XML.
namespace brdfit::klems {

struct Ring {
    double lower, upper; ///< degrees from the normal
    std::size_t patches; ///< patch k is about azimuth 360 k / patches degrees
};
inline constexpr std::array<Ring, 9> rings{{{0, 5, 1},
                                            {5, 15, 8},
                                            {15, 25, 16},
                                            {25, 35, 20},
                                            {35, 45, 24},
                                            {45, 55, 24},
                                            {55, 65, 24},
                                            {65, 75, 16},
                                            {75, 90, 12}}};
inline constexpr std::size_t patches = 145;

/// The integral of the cosine over each patch.
std::vector<double> projected_solid_angles();

/// The mean over each pair of patches, weighted by both cosines, of the sum of channels times
/// `weights`, 1/sr, [patch of wo][patch of wi]. Light comes from the patch opposite to the one that
/// it is numbered by: mirror directions have the same number.
std::vector<double> matrix(const BrdfFunction& brdf, const std::vector<double>& weights,
                           const ProgressFunction& progress = {});

/// What makes channels a luminance: of one channel, of R, G and B (Rec. 709) or of X, Y and Z.
/// Throws InputError, naming `source`, for others.
std::vector<double> luminance_weights(const std::vector<std::string>& channels,
                                      const std::string& source);

/// Writes the matrix as the reflection of front and back. `name`: of the material.
void write(const std::vector<double>& matrix, const std::string& name, const std::string& path);

} // namespace brdfit::klems

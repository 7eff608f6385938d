#pragma once

#include "host/files/file.hpp"
#include "host/measured/samples.hpp"

#include <array>
#include <memory>
#include <string>

namespace brdfit::merl {

inline constexpr int theta_h_bins = 90, theta_d_bins = 90, phi_d_bins = 180;
inline constexpr std::size_t bins = std::size_t{90} * 90 * 180;

/// Directions at the bin centres, [theta_h][theta_d][phi_d], computed once and shared.
std::shared_ptr<const Directions> bin_directions();
/// Solid-angle measure of each bin, d(wi) d(wo) = 4 cos(theta_d) dw_h dw_d.
std::vector<float> bin_weights();
/// Where a pair of directions lies among the bins along theta_h, theta_d and phi_d: whole numbers
/// are their lower borders, phi_d in [0, 180) (reciprocity: half a turn is none).
std::array<double, 3> bin_coordinates(const Vector& wi, const Vector& wo);
/// Index of the bin that holds a pair of directions above the horizon (isotropic: azimuths count
/// only relative to each other).
std::size_t bin_of(const Vector& wi, const Vector& wo);

/// Whether the bytes begin like a MERL file: three small positive dimensions, or a size that says
/// so.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file);
/// Writes [bin] values of three channels; invalid bins become -1.
void write(const Samples& samples, const std::string& path);

} // namespace brdfit::merl

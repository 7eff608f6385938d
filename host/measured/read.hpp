#pragma once

#include "host/file.hpp"
#include "host/measured/samples.hpp"

#include <optional>
#include <string>

namespace brdfit {

/// Reads measured reflectance in any known format, recognised by content, never by name.
/// `isotropic` overrides what the data says (scattered formats only).
/// Throws InputError naming file, place and expectation for every broken input, UsageError where
/// `isotropic` contradicts the format.
Samples read_samples(const std::string& path, std::optional<bool> isotropic = std::nullopt);

/// Reads pairs of directions: `.csv` with the header wi_x,wi_y,wi_z,wo_x,wo_y,wo_z or `.npy` of
/// float32 or float64, shape (N, 6); recognised by content. Vectors are normalised when within
/// 1e-3 of unit length, otherwise InputError. Directions below the horizon are kept.
Directions read_directions(const std::string& path);

} // namespace brdfit

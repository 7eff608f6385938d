#pragma once

#include "host/directions.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace brdfit {

/// Normalises three coordinates. Returns whether they were a unit vector within 1e-3; not for NaN.
inline bool normalise(const double* v, Vector& unit) {
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double scale = 1 / length;
    unit = {v[0] * scale, v[1] * scale, v[2] * scale};
    return std::abs(length - 1) <= 1e-3; // false for NaN
}

/// Reads pairs of directions: `.csv` with the header wi_x,wi_y,wi_z,wo_x,wo_y,wo_z or `.npy` of
/// float32 or float64, shape (N, 6); recognised by content. Vectors are normalised when within
/// 1e-3 of unit length, otherwise InputError. Directions below the horizon are kept.
Directions read_directions(const std::string& path);

/// Reads viewers: wo of such a file, or of one that has wo_x,wo_y,wo_z alone (.npy: shape (N, 3)).
/// Throws InputError also for one that is not above the horizon.
std::vector<Vector> read_viewers(const std::string& path);

} // namespace brdfit

#pragma once

#include "host/directions.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace brdfit {

/// Pairs of directions along a line, for plots: x of a curve in degrees, and its pairs.
struct Line {
    std::vector<double> x;
    Directions directions;
};

/// Viewers in the plane of incidence, from -90 to 90 degrees; light from the left at theta_i
/// degrees.
Line incidence_line(double theta_i, std::size_t steps_a_degree);

/// The angle of the half vector from 0 to 90 degrees, with light and viewer theta_d degrees to its
/// sides.
Line half_line(double theta_d, std::size_t steps_a_degree);

/// Directions of light and viewer whose half vector is theta_h from the normal and which are
/// theta_d from it, to either side, radians: across the plane of normal and half vector, where both
/// stay above the horizon longest.
std::pair<Vector, Vector> half_pair(double theta_h, double theta_d);

} // namespace brdfit

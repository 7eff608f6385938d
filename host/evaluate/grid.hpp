#pragma once

#include "host/directions.hpp"
#include "host/measured/samples.hpp"
#include "host/progress.hpp"

#include <vector>

namespace brdfit {

/// A MERL file at any pairs of directions, in 1/sr, [channel][pair]: linear between the centres of
/// bins, whose axes are taken as they are (sqrt(theta_h), theta_d, phi_d periodic), and constant
/// beyond the outer ones. Bins that are not valid have no part; where none is, and below the
/// horizon, 0. `samples` are those of merl::read.
std::vector<float> evaluate_merl(const Samples& samples, const Directions& directions,
                                 const ProgressFunction& progress = {});

/// A UTIA file likewise: linear between nodes in theta and phi of wi and wo, periodic in phi,
/// constant beyond 75 degrees. `samples` are those of utia::read.
std::vector<float> evaluate_utia(const Samples& samples, const Directions& directions,
                                 const ProgressFunction& progress = {});

} // namespace brdfit

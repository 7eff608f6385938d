#pragma once

#include "host/evaluate/sample.hpp"
#include "tests/support/hemisphere.hpp"

#include <cstddef>
#include <vector>

namespace brdfit::test {

/// Standard deviations at which a check fails by chance once in 1e9 times.
inline constexpr double far_off = 6;

/// The directions above the horizon.
std::vector<Vector> above(const DirectionSamples& samples);
/// The first `most` of the directions.
std::vector<Vector> hints_of(std::vector<Vector> directions, std::size_t most = 16384);
/// The cells of the sampler's density at wo.
Hemisphere density_cells(const Sampler& sampler, const Vector& wo,
                         const std::vector<Vector>& hints);
/// How many standard deviations chi-square is above its mean (Wilson and Hilferty 1931).
double deviation(double chi2, double degrees);
/// Chi-square of `total` samples, those `above` the horizon and the others, against the density.
void expect_distribution(const Hemisphere& cells, const std::vector<Vector>& above,
                         std::size_t total);
/// Draws `total` samples from each of several wo and checks them against the sampler's density.
void expect_samples_follow_density(const Material& material, std::size_t total);

} // namespace brdfit::test

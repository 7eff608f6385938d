#pragma once

#include "host/microfacet/distribution.hpp"
#include "host/quadrature.hpp"

#include <array>
#include <cstddef>

namespace brdfit {

/// Polar angles of a part, in its frame: from least_theta to greatest_theta or, of a Gaussian, to
/// where it has ended at the azimuth (see kernels/terms/distribution.cl).
double least_theta(const DistributionPart& part);
double greatest_theta(const DistributionPart& part);
/// The ellipse of whose parameter psi a part's azimuths are taken: (cos phi, sin phi) ~ (stretch_x
/// cos psi, stretch_y sin psi).
std::array<double, 2> azimuth_stretch(const DistributionPart& part);

/// Shares of the range of polar angles, with weights adding up to 1, and psi over 2 pi: 128 x 256
/// nodes at fineness 1, twice as many each way at 2, and so on.
struct PartNodes {
    Quadrature shares, psis;
};
PartNodes nodes_of(const DistributionPart& part, std::size_t fineness);

} // namespace brdfit

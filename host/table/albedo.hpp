#pragma once

#include "host/device/device.hpp"
#include "host/model/material.hpp"
#include "host/table/integrator.hpp"

#include <cstddef>
#include <vector>

namespace brdfit {

/// Directional albedos R = integral over wi of f iz on a grid of viewers: theta from 0 to pi/2, both
/// included, phi from 0 in equal steps of the full turn; entry [phi][theta].
struct Albedo {
    std::vector<std::string> channels;
    std::vector<double> theta, phi;          ///< radians
    std::vector<std::vector<double>> values; ///< [channel][phi * thetas + theta]; may be infinite
    std::vector<std::vector<double>> errors; ///< estimated absolute errors, likewise
    std::vector<double> average;             ///< [channel] hemispherical: 1/pi integral of R oz dwo
    std::vector<double> average_error;       ///< [channel]
    /// Measured data: the part of the projected hemisphere of wi, and of the hemisphere of wo and wi
    /// for the average, that was measured and so counts. Empty and 1 for materials.
    std::vector<double> measured;
    double average_measured = 1;
    std::vector<std::string> notes; ///< how it was integrated, for provenance

    std::size_t count() const { return theta.size() * phi.size(); }
};

/// Equal steps of theta over [0, pi/2] and of phi over [0, 2 pi). `thetas` is at least 2.
struct AlbedoGrid {
    std::size_t thetas = 91, phis = 1;
    std::vector<double> theta() const;
    std::vector<double> phi() const;
};

/// Nodes in mu = wo.z and weights that sum 2 R mu to the hemispherical albedo: Gauss-Legendre of
/// `count` points in mu^(1/4), as R changes fast, and may grow without bounds, where mu is small.
struct CosineRule {
    std::vector<double> mu, weight;
    explicit CosineRule(std::size_t count);
};

/// The albedo of a material. `tolerance`: absolute, of the directional albedos; see
/// AlbedoIntegrator for what is reached where. Throws UsageError for a tolerance below
/// least_tolerance.
Albedo albedo(const Device& device, const Material& material, const AlbedoGrid& grid,
              double tolerance);

/// Throws UsageError unless the tolerance is a number that single precision can reach.
void require_tolerance(double tolerance);

} // namespace brdfit

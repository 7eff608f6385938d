#pragma once

#include "host/albedo/integrator.hpp"
#include "host/device/device.hpp"
#include "host/model/material.hpp"

#include <cstddef>
#include <vector>

namespace brdfit {

/// Directional albedos R = integral over wi of f iz, for viewers wo.
struct Albedo {
    std::vector<std::string> channels;
    std::vector<double> theta, phi; ///< [viewer] radians
    std::size_t columns = 0;        ///< viewers of one phi where they are a grid [phi][theta]
    std::vector<std::vector<double>> values; ///< [channel][viewer]; infinite where it diverges
    std::vector<std::vector<double>> errors; ///< [channel][viewer] estimated, absolute
    std::vector<double> average;             ///< [channel] hemispherical: 1/pi integral of R oz dwo
    std::vector<double> average_error;       ///< [channel]
    /// Measured data: the part of the projected hemisphere of wi, and of the hemisphere of wo and
    /// wi for the average, that was measured and so counts. Empty and 1 for materials.
    std::vector<double> measured;
    double average_measured = 1;
    std::vector<std::string> notes; ///< how it was integrated, for provenance

    std::size_t count() const { return theta.size(); }
};

/// Viewers in equal steps of theta over [0, pi/2], both included (at least 2), and of phi over
/// [0, 2 pi).
struct AlbedoGrid {
    std::size_t thetas = 91, phis = 1;
    /// Sets an albedo's theta, phi and columns.
    void place(Albedo& albedo) const;
};

/// Nodes in mu = wo.z and weights that sum 2 R mu to the hemispherical albedo: Gauss-Legendre of
/// `count` points in mu^(1/4), as R changes fast, and may grow without bounds, where mu is small.
/// `split`: where in (0, 1) R may have a slope that is infinite from above, or 0; there are as many
/// points on either side of it.
struct CosineRule {
    std::vector<double> mu, weight;
    explicit CosineRule(std::size_t count, double split = 0);
};

/// The albedo of a material. `tolerance`: absolute, of the directional albedos; see
/// AlbedoIntegrator for what is reached where. Throws UsageError for a tolerance below
/// least_tolerance.
Albedo albedo(const Device& device, const Material& material, const AlbedoGrid& grid,
              double tolerance, const ProgressFunction& progress = {});

/// The directional albedos alone, of viewers of the caller's choice: theta in [0, pi/2], at pi/2
/// the limit, and phi, one each a viewer; values, errors and notes as albedo() gives them.
Albedo directional_albedo(const Device& device, const Material& material, std::vector<double> theta,
                          std::vector<double> phi, double tolerance,
                          const ProgressFunction& progress = {});

/// Throws UsageError unless the tolerance is a number that single precision can reach.
void require_tolerance(double tolerance);

} // namespace brdfit

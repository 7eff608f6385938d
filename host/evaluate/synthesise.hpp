#pragma once

#include "host/device/device.hpp"
#include "host/measured/samples.hpp"
#include "host/model/material.hpp"

#include <cstdint>
#include <memory>
#include <string>

namespace brdfit {

/// `count` pairs of directions above the horizon, the same for one seed: half of them uniform over
/// both hemispheres, half with the half vector near the normal (log-uniform angles of 0.001 to 1
/// radian), where specular lobes are. `isotropic`: phi_i is 0 in all of them.
std::shared_ptr<const Directions> random_directions(std::size_t count, bool isotropic,
                                                    std::uint64_t seed);

/// The material seen at the directions as measured data: y (1 + noise N(0, 1)), the noise of a
/// sample depending on seed, sample and channel alone. Isotropic where the material is and every wi
/// has azimuth 0.
Samples synthesise(const Device& device, const Material& material,
                   std::shared_ptr<const Directions> directions, double noise, std::uint64_t seed);

/// The same on MERL's grid, with its weights. Throws InputError for an anisotropic material.
Samples synthesise_merl(const Device& device, const Material& material, double noise,
                        std::uint64_t seed, const std::string& source);

} // namespace brdfit

#pragma once

#include "host/device/device.hpp"
#include "host/measured/samples.hpp"
#include "host/model/material.hpp"

#include <vector>

namespace brdfit {

/// The material's BRDF in 1/sr at each pair of directions, [channel][pair]: 0 below the horizon,
/// finite everywhere.
std::vector<float> evaluate(const Device& device, const Material& material,
                            const Directions& directions);

/// A model's own value and its derivatives by theta, without kd or ks.
struct ModelValues {
    std::vector<float> value; ///< [pair]
    std::vector<std::vector<float>>
        derivatives; ///< [parameter][pair]; a diffuse model: by f0, where it depends on it
};

/// g (Kind::Lobe) or the diffuse shape (the others; theta is then empty, or f0 alone where the
/// shape depends on it) at each pair of directions, in the isotropic or anisotropic form.
ModelValues evaluate_model(const Device& device, const Model& model, bool isotropic,
                           const std::vector<double>& theta, const Directions& directions);

} // namespace brdfit

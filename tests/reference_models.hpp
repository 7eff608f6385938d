#pragma once

#include "host/measured/samples.hpp"
#include "host/model/material.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// The models once more, from the papers' equations and in float64, to hold the kernels against:
/// a lobe's g, or a diffuse model's shape (theta as for evaluate_model). 0 below the horizon.
/// Throws std::invalid_argument for a model that has no reference here: write one with every model.
double reference_value(const std::string& model, bool isotropic, const std::vector<double>& theta,
                       const Vector& wi, const Vector& wo);

/// kd diffuse + sum of ks g, for one channel.
double reference_evaluate(const Material& material, std::size_t channel, const Vector& wi,
                          const Vector& wo);

} // namespace brdfit

#pragma once

#include "host/directions.hpp"
#include "host/model/material.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// The models once more, from the papers' equations and in float64, to hold the kernels against:
/// a lobe's g, or a diffuse model's shape (theta as for evaluate_model). 0 below the horizon.
/// Throws std::invalid_argument for a model that has no reference here: write one with every model.
double reference_value(const std::string& model, bool isotropic, const std::vector<double>& theta,
                       const Vector& wi, const Vector& wo);

/// reference_value where component k (0 to 2: of wi, 3 to 5: of wo) is `change` float32 roundings
/// off; the half vector and c stay, as kernels get them apart.
double reference_value_rounded(const std::string& model, bool isotropic,
                               const std::vector<double>& theta, const Vector& wi, const Vector& wo,
                               std::size_t k, double change);

/// A direction as a frame sees it that is turned about n, degrees from x towards y.
Vector seen_turned(const Vector& v, double degrees);

/// kd diffuse + sum of ks g, for one channel.
double reference_evaluate(const Material& material, std::size_t channel, const Vector& wi,
                          const Vector& wo);

} // namespace brdfit

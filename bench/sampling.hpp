#pragma once

#include "host/device/device.hpp"
#include "host/model/material.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace brdfit::bench {

/// How well and how fast directions are drawn for a material (the numerical side of Kurt et al.
/// 2010, Fig. 11). The estimator is that of the albedo, averaged over channels.
struct SamplingResult {
    std::string name;
    double albedo = 0;
    double variance = 0;          ///< of one sample's weight
    double cosine_variance = 0;   ///< the same with directions from the cosine's density
    double rejected = 0;          ///< share of samples below the horizon
    double sobol = 0, philox = 0; ///< samples a second on all of the device
};
nlohmann::ordered_json to_json(const SamplingResult& result);

/// A material to measure and what it is called.
struct NamedMaterial {
    std::string name;
    Material material;
};
/// Every lobe model of the catalogue with the same roughness 0.2, exponents 2 / 0.2^2, f0 = 0.5.
std::vector<NamedMaterial> catalogue_materials();

/// Measures the sampler of a material for a viewer `theta_o` radians from the normal.
SamplingResult measure_sampling(const Device& device, const NamedMaterial& named, double theta_o);

} // namespace brdfit::bench

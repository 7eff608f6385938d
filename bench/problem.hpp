#pragma once

#include "host/device/device.hpp"
#include "host/measured/samples.hpp"
#include "host/model/material.hpp"
#include "host/model/structure.hpp"

#include <string>
#include <vector>

namespace brdfit::bench {

/// A model to measure: one lobe over its diffuse shape, at shapes where neither error nor gradient
/// vanishes on data_of's samples.
struct Problem {
    Structure structure;
    std::vector<double> theta;
    std::string name() const { return structure.name(); }
    Material material() const; ///< three channels, with theta
};

/// Those of the catalogue's models that bench/native/scalar.hpp can check, or the ones named among
/// them: a new model is measured without mention. Throws UsageError for a name that is not among
/// them.
std::vector<Problem> problems(const std::vector<std::string>& names = {});

/// Candidates of the batched search: `count` values of theta around the problem's.
std::vector<std::vector<double>> candidates_of(const Problem& problem, std::size_t count);

/// What everything is measured on: a noisy `kurt` material on MERL's grid (1 458 000 bins). Valid
/// are the samples above the horizon, or about `most` of them, evenly spaced, where that is not 0.
Samples data_of(const Device& device, std::size_t most);

} // namespace brdfit::bench

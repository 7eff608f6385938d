#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/model/material.hpp"
#include "host/progress.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace brdfit {

/// theta of all lobes, each in the isotropic form or not, as kernels read it. Where a lobe has a
/// table, the offset of each lobe's table follows (0: none) and then the tables.
std::vector<float> device_parameters(const Material& material, bool isotropic);

/// Makes pairs [first, first + count) of directions, to be the first `count` of `into`.
using MakePairs = std::function<void(std::size_t first, std::size_t count, Directions& into)>;

/// A material on a device, ready to be evaluated: for many calls, by any threads.
class Evaluator {
  public:
    Evaluator(const Device& device, const Material& material);
    /// The BRDF in 1/sr at `count` pairs of directions, [channel][pair]: 0 below the horizon,
    /// finite everywhere. `make` is called for some of them at a time, in order.
    std::vector<float> values(std::size_t count, const MakePairs& make,
                              const ProgressFunction& progress = {}) const;

  private:
    const Device device_;
    const std::size_t channels_;
    cl::Program program_;
    cl::Buffer theta_, coefficients_;
};

/// The same of one call, at pairs that are there.
std::vector<float> evaluate(const Device& device, const Material& material,
                            const Directions& directions, const ProgressFunction& progress = {});

/// A model's own value and its derivatives by theta, without kd or ks.
struct ModelValues {
    std::vector<float> value; ///< [pair]
    std::vector<std::vector<float>>
        derivatives; ///< [parameter][pair]; a diffuse model: by f0, where it depends on it
};

/// g (Kind::Lobe) or the diffuse shape (the others; theta is then empty, or f0 alone where the
/// shape depends on it) at each pair of directions, in the isotropic or anisotropic form. Throws
/// UsageError for a model that reads a table.
ModelValues evaluate_model(const Device& device, const Model& model, bool isotropic,
                           const std::vector<double>& theta, const Directions& directions);

/// Runs a kernel whose arguments 0 and 1 are directions and their count in vectors over all pairs,
/// in passes; its other arguments but `out_argument` must be set. Returns its planes,
/// [output][pair].
std::vector<float> run_over_directions(const Device& device, cl::Kernel& kernel,
                                       cl_uint out_argument, std::size_t outputs, std::size_t count,
                                       const MakePairs& make,
                                       const ProgressFunction& progress = {});
std::vector<float> run_over_directions(const Device& device, cl::Kernel& kernel,
                                       cl_uint out_argument, std::size_t outputs,
                                       const Directions& directions,
                                       const ProgressFunction& progress = {});

} // namespace brdfit

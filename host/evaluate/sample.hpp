#pragma once

#include "host/device/device.hpp"
#include "host/measured/samples.hpp"
#include "host/model/material.hpp"
#include "host/model/structure.hpp"
#include "host/progress.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace brdfit {

/// Where the uniform numbers come from. Either way sample i is a function of seed and i alone.
enum class Sequence {
    Philox, ///< independent numbers (Philox 4x32-10)
    Sobol   ///< Sobol points with Owen's scrambling: spread evenly
};

/// The key of Philox in the first two, or the scrambles of Sobol's first three dimensions.
std::array<std::uint32_t, 4> keys_of(std::uint64_t seed, Sequence sequence);

/// Directions drawn for one wo. Rejected samples (below the horizon) have density and weights 0.
struct DirectionSamples {
    std::vector<float> wi_x, wi_y, wi_z; ///< [sample] unit
    std::vector<float> pdf;              ///< [sample] of the mixture, by solid angle of wi, 1/sr
    std::vector<float> weights;          ///< [channel][sample] f iz / pdf

    std::size_t count() const { return pdf.size(); }
    const float* weight(std::size_t channel) const { return weights.data() + channel * count(); }
};

/// The structure of a program that draws from a material.
Structure drawn_structure(const Material& material);

/// What kernels that draw from a material read of it, on the device.
struct DrawnMaterial {
    /// `program` is of drawn_structure and has passes/sample.cl, whose kernel tabulates albedos.
    DrawnMaterial(const Device& device, const cl::Program& program, const Material& material);

    cl::Buffer theta;
    cl::Buffer coefficients; ///< [channel][component]: diffuse and lobes
    cl::Buffer strengths;    ///< [component] mean coefficients, the largest 1
    cl::Buffer table;        ///< of the components' albedos, see passes/sample.cl
};

/// Draws directions for a material: one of its components (diffuse and lobes) with probability
/// proportional to the albedo at wo, averaged over channels; then a direction as that component's
/// model draws it. The albedos are tabulated once, here.
class Sampler {
  public:
    Sampler(const Device& device, const Material& material);

    /// Samples first to first + n - 1 for wo. Throws UsageError where n or first + n is not in
    /// [1, 2^32) or wo is not above the horizon and of unit length.
    DirectionSamples sample(const Vector& wo, std::size_t n, std::uint64_t seed, Sequence sequence,
                            std::size_t first = 0) const;
    /// Draws without fetching the results: the device's work alone. n is at most a pass,
    /// samples_a_pass(); waits for the device.
    void draw(const Vector& wo, std::size_t n, std::uint64_t seed, Sequence sequence) const;
    std::size_t samples_a_pass() const { return pass_; }
    /// The density of wi given wo at each pair, 1/sr; 0 below the horizon.
    std::vector<float> density(const Directions& directions,
                               const ProgressFunction& progress = {}) const;

  private:
    /// Draws samples first to first + n - 1 into out_.
    void draw(const Vector& wo, std::size_t first, std::size_t n, std::uint64_t seed,
              Sequence sequence) const;

    Device device_;
    std::size_t channels_;
    std::size_t pass_ = 0; ///< a multiple of the vector width
    cl::Program program_;
    DrawnMaterial material_;
    cl::Buffer out_;
};

/// Draws n directions for a material at wo; see Sampler.
DirectionSamples sample_material(const Device& device, const Material& material, const Vector& wo,
                                 std::size_t n, std::uint64_t seed, Sequence sequence);
/// The density of the material's sampler at each pair; see Sampler.
std::vector<float> density(const Device& device, const Material& material,
                           const Directions& directions, const ProgressFunction& progress = {});

} // namespace brdfit

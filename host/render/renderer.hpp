#pragma once

#include "host/device/device.hpp"
#include "host/evaluate/measured.hpp"
#include "host/evaluate/sample.hpp"
#include "host/model/material.hpp"
#include "host/progress.hpp"
#include "host/render/film.hpp"
#include "host/render/scene.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace brdfit {

struct RenderSettings {
    std::size_t samples = 64; ///< a pixel, at least 1; with a tolerance: at most
    std::uint64_t seed = 0;   ///< another seed, other noise
    /// Stops where Film::noise() is at most that.
    std::optional<double> tolerance;
    strategy drawn = BOTH;
    int bounces = 0; ///< between shapes, 0 to most_bounces
};
inline constexpr int most_bounces = 64;
inline constexpr std::size_t most_render_samples = std::size_t{1} << 24;

/// Which of a BRDF's channels are red, green and blue: of one channel that one, of three those,
/// of wavelengths the nearest to 620, 545 and 465 nm. Throws InputError naming `source` for others.
std::array<std::size_t, 3> rgb_channels(const std::vector<std::string>& channels,
                                        const std::string& source);

/// Renders scenes of one BRDF. Pictures depend on scene, BRDF, settings and the device's rounding
/// alone: not on threads or on how the work is split.
class Renderer {
  public:
    /// Throws InputError like rgb_channels and build_render_program.
    Renderer(const Device& device, const Material& material, const std::string& source);
    /// A measured BRDF, by whose values paths are weighed; their directions are drawn by the
    /// proposal, to which an even part is added, so that no direction is missed.
    Renderer(const Device& device, std::shared_ptr<const MeasuredBrdf> measured,
             const Material& proposal, const std::string& source);

    /// Throws UsageError for settings out of range and scenes without light.
    Film render(const Scene& scene, const RenderSettings& settings,
                const ProgressFunction& progress = {}) const;

  private:
    struct OnDevice;
    std::size_t samples_at_once() const; ///< that bound the memory of a launch
    std::vector<float> material_means(const OnDevice& scene, std::size_t first, std::size_t pixels,
                                      std::size_t count) const;
    std::vector<float> measured_means(const OnDevice& scene, std::size_t first, std::size_t pixels,
                                      std::size_t count) const;

    Device device_;
    std::array<std::size_t, 3> rgb_;
    std::shared_ptr<const MeasuredBrdf> measured_; ///< or none
    cl::Program program_;
    DrawnMaterial drawn_;
};

} // namespace brdfit

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace brdfit {

/// A direction in the local frame: x = tangent, y = bitangent, z = normal.
using Vector = std::array<double, 3>;

/// Unit direction at polar angle theta from the normal and azimuth phi from x, in radians.
Vector direction(double theta, double phi);

/// Pairs of unit directions, wi to the light and wo to the viewer, with their unit half vector h
/// and c = wi.h = wo.h. Stored as float32 planes; h and c come from float64 directions, so that
/// sharp lobes do not suffer from cancellation in wi + wo.
class Directions {
  public:
    enum Plane { WiX, WiY, WiZ, WoX, WoY, WoZ, HX, HY, HZ, C, plane_count };

    explicit Directions(std::size_t count = 0) : count_(count), data_(count * plane_count) {}

    std::size_t count() const { return count_; }
    const float* plane(Plane p) const { return data_.data() + count_ * p; }
    float* plane(Plane p) { return data_.data() + count_ * p; }
    const std::vector<float>& data() const { return data_; }
    /// Sets pair k; wi and wo must be unit vectors. Opposite ones get h = n, c = 0.
    void set(std::size_t k, const Vector& wi, const Vector& wo);
    /// Sets pair k where the half vector is known better than wi + wo tells it.
    void set(std::size_t k, const Vector& wi, const Vector& wo, const Vector& h, double c);
    Vector wi(std::size_t k) const { return at(WiX, k); }
    Vector wo(std::size_t k) const { return at(WoX, k); }
    /// wi and wo of pair k to the precision of h and c, which near grazing is better than wi(k)'s.
    std::pair<Vector, Vector> pair(std::size_t k) const;
    /// Whether both directions of pair k are above the horizon.
    bool above_horizon(std::size_t k) const { return plane(WiZ)[k] > 0 && plane(WoZ)[k] > 0; }

  private:
    Vector at(Plane first, std::size_t k) const {
        return {plane(first)[k], plane(static_cast<Plane>(first + 1))[k],
                plane(static_cast<Plane>(first + 2))[k]};
    }
    std::size_t count_;
    std::vector<float> data_; // [plane][pair]
};

/// Measured (or synthesised) reflectance: K samples of C channels.
struct Samples {
    std::string source; ///< path it was read from
    std::string format; ///< name of the format, for people
    std::string sha256; ///< of the file's bytes; empty when synthesised
    std::vector<std::string> channels;
    std::shared_ptr<const Directions> directions; ///< K pairs; shared between files on one grid
    std::vector<float> values;                    ///< BRDF in 1/sr, [channel][sample]
    std::vector<float> weights;      ///< w_k >= 0, solid-angle measure of the sample; empty: all 1
    std::vector<std::uint8_t> valid; ///< [sample] 0: dropped by every consumer
    bool isotropic = true;

    std::size_t count() const { return directions ? directions->count() : 0; }
    const float* channel(std::size_t c) const { return values.data() + c * count(); }
    float* channel(std::size_t c) { return values.data() + c * count(); }
    std::size_t valid_count() const;
};

} // namespace brdfit

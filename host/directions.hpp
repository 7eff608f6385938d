#pragma once

#include "kernels/base/direction_planes.h"

#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace brdfit {

inline constexpr double pi = 3.14159265358979323846, degree = pi / 180; ///< radians

/// Leaves the elements that a vector is made with as they are: for large ones that several threads
/// fill.
template <typename T>
struct Unfilled : std::allocator<T> {
    template <typename U>
    struct rebind {
        using other = Unfilled<U>;
    };
    template <typename U, typename... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        if constexpr (sizeof...(Arguments) == 0)
            ::new (static_cast<void*>(at)) U;
        else
            ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
};

/// A direction in the local frame: x = tangent, y = bitangent, z = normal.
using Vector = std::array<double, 3>;

/// Unit direction at polar angle theta from the normal and azimuth phi from x, in radians.
Vector direction(double theta, double phi);

/// Pairs of unit directions, wi to the light and wo to the viewer, with their unit half vector h
/// and c = wi.h = wo.h. Stored as float32 planes; h and c come from float64 directions, so that
/// sharp lobes do not suffer from cancellation in wi + wo.
class Directions {
  public:
    /// In the kernels' order.
    enum Plane {
        WiX = WI_X,
        WiY = WI_Y,
        WiZ = WI_Z,
        WoX = WO_X,
        WoY = WO_Y,
        WoZ = WO_Z,
        HX = H_X,
        HY = H_Y,
        HZ = H_Z,
        C = HALF_COSINE,
        plane_count = DIRECTION_PLANES
    };

    /// All planes are 0.
    explicit Directions(std::size_t count = 0) : count_(count), data_(count * plane_count, 0.0F) {}
    /// Its planes are still to be filled, each to its end.
    static Directions unfilled(std::size_t count) {
        Directions directions;
        directions.count_ = count;
        directions.data_.resize(count * plane_count);
        return directions;
    }

    std::size_t count() const { return count_; }
    const float* plane(Plane p) const { return data_.data() + count_ * p; }
    float* plane(Plane p) { return data_.data() + count_ * p; }
    const std::vector<float, Unfilled<float>>& data() const { return data_; }
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
    std::vector<float, Unfilled<float>> data_; // [plane][pair]
};

} // namespace brdfit

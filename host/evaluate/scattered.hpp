#pragma once

#include "host/directions.hpp"
#include "host/evaluate/relative_error.hpp"
#include "host/measured/samples.hpp"
#include "host/progress.hpp"

#include <memory>
#include <vector>

namespace brdfit {

/// Scattered samples at any pair of directions: Shepard's method, "A Two-Dimensional Interpolation
/// Function for Irregularly-Spaced Data", 1968, the mean of the eight nearest samples weighted by
/// the inverse square of their distance.
///
/// Distances are taken where a lobe is smooth and symmetries hold: sqrt(theta_h) (with its azimuth
/// where the data is anisotropic) and the difference vector's sine along and across h. wi and wo
/// may change places; isotropic data is mirrored too. Limits: at a sample its own value; between
/// samples nothing sharper than their spacing; beyond them, the mean of the nearest, however far.
class ScatteredBrdf {
  public:
    /// `samples` must have a valid one and outlive this.
    explicit ScatteredBrdf(const Samples& samples);
    ~ScatteredBrdf();

    /// 1/sr, [channel][pair]; 0 below the horizon.
    std::vector<float> evaluate(const Directions& directions,
                                const ProgressFunction& progress = {}) const;

    /// How well the samples tell each other: the error at each, or at 20,000 of them evenly, of
    /// what the others make of it.
    RelativeError leave_one_out() const;

  private:
    struct Tree;
    /// Values at a pair from the nearest samples but `left_out`; `values[channel * stride]`.
    void interpolate(const Vector& wi, const Vector& wo, std::size_t left_out, std::size_t stride,
                     float* values) const;
    const Samples& samples_;
    std::unique_ptr<Tree> tree_;
};

} // namespace brdfit

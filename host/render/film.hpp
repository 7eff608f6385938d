#pragma once

#include "host/render/environment.hpp"

#include <cstddef>
#include <vector>

namespace brdfit {

/// What a camera's film gathers: means over batches of samples that are independent of each other.
class Film {
  public:
    /// Sums of these planes, [plane][pixel]: radiance in red, green, blue, and the share of the
    /// pixel that shapes cover.
    enum Plane { Red, Green, Blue, Covered, planes };

    Film(std::size_t width, std::size_t height);

    std::size_t width() const { return width_; }
    std::size_t height() const { return height_; }
    std::size_t pixels() const { return width_ * height_; }
    std::size_t samples() const { return samples_; } ///< a pixel
    std::size_t batches() const { return batches_; }

    /// Adds the means of a batch of `count` samples a pixel, [plane][pixel - first], for the pixels
    /// from `first` on. A batch is whole when all pixels had it; then comes end_batch.
    void add(const std::vector<float>& means, std::size_t first, std::size_t count);
    void end_batch(std::size_t count);

    double mean(Plane plane, std::size_t pixel) const;
    /// Of mean(), by how the batches differ; infinite for one batch.
    double standard_error(Plane plane, std::size_t pixel) const;
    /// Standard error of a pixel, root mean square over channels and covered pixels, by their mean
    /// radiance; infinite for one batch, 0 for a black picture.
    double noise() const;

  private:
    std::size_t width_, height_, samples_ = 0, batches_ = 0;
    std::vector<double> sums_, squares_; ///< of count * mean, and count * mean^2
};

} // namespace brdfit

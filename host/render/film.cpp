#include "host/render/film.hpp"

#include <cmath>
#include <limits>

namespace brdfit {

Film::Film(std::size_t width, std::size_t height)
    : width_(width), height_(height), sums_(planes * width * height),
      squares_(planes * width * height) {}

void Film::add(const std::vector<float>& means, std::size_t first, std::size_t count) {
    const std::size_t part = means.size() / planes;
    const auto weight = static_cast<double>(count);
    for (std::size_t plane = 0; plane < planes; ++plane)
        for (std::size_t i = 0; i < part; ++i) {
            const double mean = means[plane * part + i];
            sums_[plane * pixels() + first + i] += weight * mean;
            squares_[plane * pixels() + first + i] += weight * mean * mean;
        }
}

void Film::end_batch(std::size_t count) {
    samples_ += count;
    ++batches_;
}

double Film::mean(Plane plane, std::size_t pixel) const {
    return sums_[plane * pixels() + pixel] / static_cast<double>(samples_);
}

double Film::standard_error(Plane plane, std::size_t pixel) const {
    if (batches_ < 2)
        return std::numeric_limits<double>::infinity();
    const double n = static_cast<double>(samples_), average = mean(plane, pixel);
    const double spread = squares_[plane * pixels() + pixel] - n * average * average;
    return std::sqrt(std::max(0.0, spread) / (static_cast<double>(batches_ - 1) * n));
}

double Film::noise() const {
    double squares = 0, sum = 0, count = 0;
    for (std::size_t pixel = 0; pixel < pixels(); ++pixel) {
        if (mean(Covered, pixel) <= 0)
            continue;
        for (const Plane plane : {Red, Green, Blue}) {
            squares += std::pow(standard_error(plane, pixel), 2);
            sum += mean(plane, pixel);
            ++count;
        }
    }
    return sum > 0 ? std::sqrt(squares / count) / (sum / count) : 0;
}

} // namespace brdfit

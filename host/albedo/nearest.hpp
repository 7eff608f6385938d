#pragma once

#include "host/directions.hpp"

#include <utility>
#include <vector>

namespace brdfit {

/// Finds the nearest of many directions of a hemisphere, by the distance of their ends.
class Nearest {
  public:
    explicit Nearest(std::vector<Vector> directions);

    /// The k nearest (fewer where there are fewer) as squared distance and index, nearest first.
    std::vector<std::pair<double, std::size_t>> find(const Vector& at, std::size_t k) const;

  private:
    std::size_t cell(double x) const;

    std::vector<Vector> directions_;
    std::size_t side_;                            // cells along x and y of [-1, 1]
    std::vector<std::vector<std::size_t>> cells_; // [y][x]
};

} // namespace brdfit

#pragma once

#include "host/directions.hpp"

#include <functional>
#include <vector>

namespace brdfit::test {

/// Values of a function at many directions.
using OnHemisphere = std::function<std::vector<double>(const std::vector<Vector>&)>;

/// The upper hemisphere in cells of polar angle and azimuth, halved in both until the integral of a
/// function over each is known: sharp lobes need no knowledge of where they are beyond a few hints.
class Hemisphere {
  public:
    /// `tolerance`: absolute error a cell; cells with more than a 2048th of `hints` are halved
    /// anyway.
    Hemisphere(const OnHemisphere& function, double tolerance, const std::vector<Vector>& hints);

    double integral() const;
    /// Integral over each leaf, and how many of `directions` (above the horizon) lie in it.
    struct Leaf {
        double integral;
        std::size_t count;
    };
    std::vector<Leaf> count(const std::vector<Vector>& directions) const;

  private:
    struct Node {
        double theta, phi, width, height; ///< lower corner; extent in phi, in theta
        double integral = 0;
        std::size_t children = 0; ///< first of four; 0: a leaf
    };
    void evaluate(const OnHemisphere& function, std::size_t begin);
    std::size_t leaf_of(const Vector& direction) const;

    std::vector<Node> nodes_;
};

} // namespace brdfit::test

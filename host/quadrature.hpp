#pragma once

#include <cstddef>
#include <vector>

namespace brdfit {

/// Nodes and weights over [0, 1] or another range that they come with.
struct Quadrature {
    std::vector<double> x, w;
    std::size_t size() const { return x.size(); }
};

/// Gauss-Legendre over [0, 1].
Quadrature gauss_legendre(std::size_t n);
/// Gauss-Legendre of n nodes between each two of the ascending ends.
Quadrature gauss_legendre(const std::vector<double>& ends, std::size_t n);

} // namespace brdfit

#pragma once

#include "host/microfacet/table.hpp"

#include <vector>

namespace brdfit {

/// Directional reflectance of a table's lobe at ks = 1, R = (1 - f0) R0 + f0 R1, between the
/// table's nodes.
class TableReflectance {
  public:
    /// `f0`: 0 to 1.
    TableReflectance(const MicrofacetTable& table, double f0, bool correlated);

    /// R at a unit direction above the horizon or on it.
    double at(const Vector& k) const;
    /// What R may be off by from that of the BRDF as it is evaluated, absolute, besides node_error:
    /// the interpolations of R and of the visible area g, each estimated by how far off the nodes
    /// about k would be if their neighbours had to say them.
    double interpolation_error(const Vector& k) const;
    /// Of R at the nodes.
    static constexpr double node_error = reflectance_error;

  private:
    Grid grid_;
    std::vector<float> reflectance_, errors_; ///< [row][column], as the grid has them
};

} // namespace brdfit

#pragma once

#include "host/microfacet/table.hpp"

#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace brdfit {

/// The nodes of a tabulated p(h), with the areas g that it implies, which are linear in its values:
/// [polar angle][azimuth], one azimuth where it is isotropic.
class DistributionNodes {
  public:
    /// Polar angles finer near the normal, azimuths in even steps.
    explicit DistributionNodes(bool isotropic);

    bool isotropic() const { return table_.width == 1; }
    std::size_t count() const { return table_.width * table_.height; }
    std::size_t azimuths() const { return table_.width; }
    double theta(std::size_t node) const { return table_.thetas[node / table_.width]; }
    double phi(std::size_t node) const { return table_.phis[node % table_.width]; }

    /// Four values and their shares, which add up to 1.
    struct Place {
        std::array<int, 4> at;
        std::array<double, 4> share;
    };
    /// Of p(h), among the nodes.
    Place place_of_normal(const Vector& h) const;
    /// Of g(k), among the rows of areas().
    Place place_of_area(const Vector& k) const;

    /// g = areas() p, at the directions of a grid; the last is the normal's, g(n) = <h.n>.
    const Eigen::MatrixXd& areas() const { return areas_; }

    /// A distribution of these values, the largest taken as 1.
    Distribution distribution(const std::vector<double>& p) const;

  private:
    void map_isotropic();
    void map_anisotropic();

    DirectionTable table_; ///< without values
    Grid grid_;            ///< of areas()
    Eigen::MatrixXd areas_;
};

} // namespace brdfit

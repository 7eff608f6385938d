#pragma once

#include "fit/programs.hpp"
#include "host/directions.hpp"
#include "host/model/material.hpp"
#include "host/model/structure.hpp"

#include <Eigen/Dense>
#include <limits>
#include <string>
#include <vector>

namespace brdfit {

/// The largest directional albedo of a material, where it is known.
struct LargestAlbedo {
    double value = std::numeric_limits<double>::quiet_NaN();
    double theta = 0; ///< degrees
    std::string channel;
    bool above_1() const { return value > 1 + albedo_tolerance; }
    static constexpr double albedo_tolerance = 1e-2; ///< that it is computed with
};

/// Viewers at these angles from the normal (degrees), of a structure in the anisotropic form at
/// `azimuths` even steps over a quarter turn, both ends included: lobes are symmetric.
std::vector<Vector> viewers_at(const std::vector<double>& thetas, bool isotropic,
                               std::size_t azimuths = 4);

/// Directional albedos of a structure's components: a material's is linear in kd and ks,
///     R_ch(wo) = sum_j a_ch,j r_j(wo; theta).
class ComponentAlbedos {
  public:
    ComponentAlbedos(ProgramCache& programs, Structure structure);

    /// r_j(wo; theta) by [wo][component], infinite where it diverges. `tolerance`: absolute, one a
    /// component (infinite: not wanted, 0 then); `relative`: to each value; either will do.
    Eigen::MatrixXd at(const std::vector<double>& theta, const std::vector<Vector>& wo,
                       const std::vector<double>& tolerance, double relative) const;

  private:
    ProgramCache& programs_;
    Structure structure_;
    StructureLayout layout_;
};

/// The largest of a material's albedos up to 85 degrees. `theta`: of all lobes; `a`: kd and ks.
LargestAlbedo largest_albedo(const ComponentAlbedos& albedos, const Structure& structure,
                             const std::vector<std::string>& channels,
                             const std::vector<double>& theta, const Eigen::MatrixXd& a);

} // namespace brdfit

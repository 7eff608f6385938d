#pragma once

#include "fit/programs.hpp"
#include "host/directions.hpp"
#include "host/model/material.hpp"
#include "host/model/structure.hpp"

#include <Eigen/Dense>
#include <cstdint>
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
/// `azimuths` even steps over a quarter turn, both ends included: lobes are symmetric. Where frames
/// are turned, such steps over half a turn, from the first frame's angle in `theta` on.
std::vector<Vector> viewers_at(const std::vector<double>& thetas, const Structure& structure,
                               std::size_t azimuths, const std::vector<double>& theta);

/// Directional albedos of a structure's components: a material's is linear in kd and ks,
///     R_ch(wo) = sum_j a_ch,j r_j(wo; theta).
class ComponentAlbedos {
  public:
    ComponentAlbedos(ProgramCache& programs, Structure structure);

    const Structure& structure() const { return structure_; }
    const StructureLayout& layout() const { return layout_; }

    /// r_j(wo; theta) by [wo][component], infinite where it diverges. `tolerance`: absolute, one a
    /// component (infinite: not wanted, 0 then); `relative`: to each value; either will do.
    Eigen::MatrixXd at(const std::vector<double>& theta, const std::vector<Vector>& wo,
                       const std::vector<double>& tolerance, double relative) const;
    /// The same from `points` points each, so that it is smooth in theta.
    Eigen::MatrixXd smooth(const std::vector<double>& theta, const std::vector<Vector>& wo,
                           std::uint32_t points) const;
    /// Derivatives of smooth by [wo][entry of the layout].
    Eigen::MatrixXd smooth_by_theta(const std::vector<double>& theta, const std::vector<Vector>& wo,
                                    std::uint32_t points) const;

  private:
    bool constant(std::size_t component) const;
    // theta of the lobe that a component takes its parameters from, anisotropic form.
    std::vector<double> own(std::size_t component, const std::vector<double>& theta) const;
    std::vector<double> values(std::size_t component, const std::vector<AlbedoTask>& tasks) const;

    ProgramCache& programs_;
    Structure structure_;
    StructureLayout layout_;
};

/// R at or below 1 for some viewers, as linear constraints on kd and ks.
struct AlbedoLimit {
    ComponentAlbedos albedos;
    std::vector<Vector> wo;
    std::uint32_t points;               ///< of each albedo; 0: as many as the tolerances take
    std::vector<double> tolerance = {}; ///< absolute, one a component; or conserved_tolerance / 4

    /// r_j(wo; theta) by [wo][component].
    Eigen::MatrixXd at(const std::vector<double>& theta) const;
};

/// R of a material fitted to conserve energy is at most 1 + this up to this angle from the normal
/// (degrees).
inline constexpr double conserved_tolerance = 1e-3;
inline constexpr int conserved_theta = 89;

/// The limit for viewers at every degree up to that, whose R is known to conserved_tolerance / 4
/// for coefficients about `a`.
AlbedoLimit limit_at_every_degree(const ComponentAlbedos& albedos, const std::vector<double>& theta,
                                  const Eigen::MatrixXd& a);

/// R by [channel][wo] from kd and ks and the components' albedos; 0 of an infinite one is nothing.
Eigen::MatrixXd material_albedos(const Eigen::MatrixXd& a, const Eigen::MatrixXd& components);

/// The rows of `a` for which R would be above 1, scaled down until it is 1; 0 for what is infinite.
Eigen::MatrixXd scaled_below_1(const Eigen::MatrixXd& a, const Eigen::MatrixXd& components);

/// The largest of a material's albedos up to 85 degrees. `theta`: of all lobes; `a`: kd and ks.
LargestAlbedo largest_albedo(const ComponentAlbedos& albedos,
                             const std::vector<std::string>& channels,
                             const std::vector<double>& theta, const Eigen::MatrixXd& a);
/// Up to conserved_theta, at every degree, within conserved_tolerance / 4 where it is 1.
LargestAlbedo largest_conserved_albedo(const ComponentAlbedos& albedos,
                                       const std::vector<std::string>& channels,
                                       const std::vector<double>& theta, const Eigen::MatrixXd& a);

} // namespace brdfit

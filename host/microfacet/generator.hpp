#pragma once

#include "host/device/device.hpp"
#include "host/microfacet/table.hpp"
#include "host/progress.hpp"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace brdfit {

struct GeneratorOptions {
    std::size_t points = 200; ///< of the grid, about
    bool facets = false;      ///< also the table of Lambertian facets; isotropic distributions only
    std::size_t fineness = 1; ///< factor on the nodes of all integrals, each way; 2 checks 1
};

inline constexpr std::size_t least_points = 16, most_points = 1000000;

/// Computes tables of distributions on a device (Ashikhmin, Premoze, Shirley 2000).
class Generator {
  public:
    explicit Generator(const Device& device);

    /// The integral of a part over the sphere, of unit amplitude.
    double mass(const DistributionPart& part) const;
    /// The distribution with its shares brought into the amplitudes.
    Distribution weighted(Distribution distribution) const;
    /// The tables of a distribution, its shares brought in: g within 1e-5 relative, R within 1e-4.
    /// Throws InputError, its message beginning with `source`, where p is 0 everywhere or too
    /// large or small for single precision, or <h.n> is not positive, and UsageError for Lambertian
    /// facets on an anisotropic distribution.
    MicrofacetTable generate(const Distribution& distribution, const GeneratorOptions& options,
                             const std::string& source,
                             const ProgressFunction& progress = {}) const;
    /// g of a table's distribution at any unit directions.
    std::vector<double> visible_areas(const Distribution& distribution,
                                      const std::vector<Vector>& directions) const;

  private:
    /// Nodes of a part, or of some of its azimuths, on the device: planes h.x, h.y, h.z, p dw, each
    /// [azimuth][row].
    struct Piece {
        std::size_t part = 0;
        cl::Buffer planes;
        std::size_t stride = 0, rows = 0; ///< padded to whole blocks and to whole vectors
        std::vector<double> shares, psis; ///< of rows and azimuths, see PartNodes
        double from = 0, to = 1;          ///< which part of all pieces it is
    };
    /// Calls `use` with the nodes of all parts in turn, so that few are on the device at once.
    /// `fineness`: of each part.
    void for_pieces(const Distribution& distribution, const std::vector<std::size_t>& fineness,
                    const std::function<void(const Piece&)>& use) const;
    std::vector<float> planes_on_host(const Piece& piece) const;
    /// Adds g of the nodes at directions to the sums.
    void add_areas(const Piece& nodes, const std::vector<Vector>& directions,
                   std::vector<double>& sums, const ProgressFunction& progress = {}) const;
    std::vector<double> areas(const Distribution& distribution,
                              const std::vector<std::size_t>& fineness,
                              const std::vector<Vector>& directions,
                              const ProgressFunction& progress = {}) const;
    /// `part_shares`: of the parts in all normals.
    void reflect(MicrofacetTable& table, std::size_t fineness,
                 const std::vector<double>& part_shares, const ProgressFunction& progress) const;
    void tabulate_facets(MicrofacetTable& table, std::size_t fineness) const;

    Device device_;
    cl::Program program_;
};

/// Where a generated BRDF reflects more than it receives.
struct EnergyReport {
    double most = 0;            ///< largest R of the table
    std::size_t directions = 0; ///< looked at: even steps of polar angle and azimuth, 200 or more
    std::size_t above = 0;      ///< of them with R > 1
    std::vector<std::array<double, 3>> where; ///< their theta, phi (radians) and R
};
/// R counts as above 1 beyond the tables' error. `f0`: 0 to 1.
EnergyReport energy_report(const MicrofacetTable& table, double f0, bool correlated);
/// Whether <h> is parallel to n, so that energy is conserved (Eq. 22).
bool mean_is_normal(const MicrofacetTable& table);

} // namespace brdfit

#pragma once

#include "host/microfacet/distribution.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace brdfit {

/// The directions that tables of the generator are over. Row r has the elevation
/// scale sinh(r / (rows - 1) asinh(pi / (2 scale))), column j the azimuth phi with
/// tan phi = stretch tan psi, psi in equal steps over the sector, both ends included but where it
/// goes round. One column: isotropic, azimuth 0.
struct Grid {
    std::size_t rows = 4, columns = 1;
    Sector sector = Sector::Isotropic;
    double scale = 1;   ///< elevation below which rows are evenly spaced
    double stretch = 1; ///< width of the azimuths near x, over that near y

    std::size_t count() const { return rows * columns; }
    double elevation(double row) const;
    double azimuth(double column) const;
    /// Unit direction of row and column, also between the nodes.
    Vector direction(double row, double column) const;
    /// The row of an elevation and the column of an azimuth, where they lie between the nodes.
    double row(double elevation) const;
    double column(double azimuth) const;
};

/// Probabilities of cells of polar angle and azimuth that half vectors of one part are drawn from.
struct SamplingCells {
    std::vector<double> edges; ///< shares of the part's range of polar angles, 0 to 1
    std::size_t columns = 1;   ///< azimuths
    std::vector<float> mass;   ///< [column][row], adds up to the part's share
};

/// The integral of Eq. 33 over pairs of directions, without beta: [row of wi][row of wo][azimuth].
struct FacetTable {
    std::size_t rows = 0, columns = 0; ///< rows of the grid's mapping; azimuths over [0, pi]
    std::vector<float> values;
};

/// A generated BRDF: the distribution and what the generator computed of it.
struct MicrofacetTable {
    Distribution distribution;
    Vector mean{};          ///< the integral of h p(h) over the sphere
    double mean_height = 0; ///< <h.n>: mean[2], or more where parts have an area_scale
    Grid grid;
    /// [row][column]: g, Eq. 18, and R at f0 = 0 and 1, Eq. 29, with independent and with
    /// correlated shadowing.
    std::vector<float> g, r0, r1, r0_correlated, r1_correlated;
    std::vector<SamplingCells> cells; ///< of each part
    double steep = 0;  ///< share of the normals above the horizon that lean by 45 degrees and more
    FacetTable facets; ///< rows 0: not computed

    bool isotropic() const { return grid.sector == Sector::Isotropic; }
    const std::vector<float>& reflectance(int f0, bool correlated) const {
        return f0 == 0 ? (correlated ? r0_correlated : r0) : (correlated ? r1_correlated : r1);
    }
};

/// What R may be off by at the nodes.
inline constexpr double reflectance_error = 1e-4;

/// A plane's value at a direction of row and column, cubic between the nodes as the kernels have
/// it.
double interpolate(const Grid& grid, const std::vector<float>& plane, double row, double column);

/// The column that stands for one beyond the sector.
std::size_t folded(const Grid& grid, std::ptrdiff_t column);

/// What of g the kernels interpolate (kernels/terms/grid.cl): g(-k), or log(g) where the normals
/// lean to one side; and whether they do.
std::pair<std::vector<float>, bool> interpolated_area(const MicrofacetTable& table);

/// The table with g alone on a grid `factor` times as fine each way, interpolated.
MicrofacetTable refined(const MicrofacetTable& table, std::size_t factor);

/// What a material makes of a table.
struct TableUse {
    double f0 = 0;           ///< of the first lobe, for the diffuse term
    bool correlated = false; ///< correlated shadowing, Eq. 14
    bool metal = false;      ///< the diffuse term of Eq. 30
};

/// c of Eq. 28: 1 / c is the integral of (1 - R(k)) (k.n), for a metal of max(0, f0 - R(k)) (k.n),
/// over the hemisphere with R as the kernels interpolate it; 0, no diffuse term, where R leaves no
/// more than its error of it.
double diffuse_constant(const MicrofacetTable& table, const TableUse& use);

/// Offsets among the words are float32 themselves, which holds integers up to here exactly.
inline constexpr std::size_t most_table_words = std::size_t{1} << 24;

/// The table as the kernels read it (kernels/terms/table_words.h): for a material's lobe, and with
/// the distribution and g alone, while the generator computes the reflectances. Both throw
/// InputError where it is larger than they can address.
std::vector<float> packed_for_lobe(const MicrofacetTable& table, const TableUse& use);
std::vector<float> packed_areas(const MicrofacetTable& table);

/// Writes an OpenEXR file, whole or not at all. Throws InputError where read_table would not take
/// it: a number that is not finite in single precision, or negative.
void write_table(const MicrofacetTable& table, const std::string& path);
/// Writes a picture of g and the reflectances over the grid (see write_preview). Returns what is
/// seen.
std::string write_table_preview(const MicrofacetTable& table, const std::string& path);
/// Reads what write_table wrote. Throws InputError naming the file and what is missing or wrong.
std::shared_ptr<const MicrofacetTable> read_table(const std::string& path);

} // namespace brdfit

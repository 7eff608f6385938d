#pragma once

#include "host/directions.hpp"
#include "host/files/json.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

// Distributions of microfacet normals p(h), by solid angle over the whole sphere, not normalised
// (Ashikhmin, Premoze, Shirley 2000, section 6).

namespace brdfit {

/// Values over directions: an image that modulates a shape, or a tabulated p.
struct DirectionTable {
    /// Tabulated p: polar angles (ascending, radians, [0, pi]) and azimuths (ascending, [0, 2 pi),
    /// one: isotropic) of the values, bilinear between them. Both empty for an image.
    std::vector<double> thetas, phis;
    std::size_t width = 0, height = 0; ///< azimuths and polar angles, or pixels
    std::vector<float> values;         ///< [row][column], >= 0
    /// An image, row 0 at the top: the disk |h.x|, |h.y| <= extent, y upwards, or where it is 0
    /// azimuths from left to right, polar angles from top to bottom.
    double extent = 1;

    bool tabulated() const { return !thetas.empty(); }
};

enum class Shape {
    Gaussian, ///< exp(-(x/z)^2 / sigma_x^2 - (y/z)^2 / sigma_y^2), Eq. 34
    Velvet,   ///< exp(-cot^2 / sigma_x^2), Eq. 35
    Tabulated ///< of a DirectionTable
};

/// amplitude times a shape in a frame of its own, 0 below that frame's horizon, times an image of
/// h.
struct DistributionPart {
    Shape shape = Shape::Gaussian;
    double amplitude = 1;
    double sigma_x = 1, sigma_y = 1; ///< infinite: cylindrical
    double tilt = 0, turn = 0; ///< radians: first about y, z towards x, then about z, x towards y
    double area_scale = 1;     ///< factor on its share of <h.n> (slanted velvet: 2)
    std::shared_ptr<const DirectionTable> table; ///< tabulated values or an image; may be null

    /// Rows of the matrix that takes a direction to the part's frame.
    std::array<double, 9> frame() const;
};

/// Which azimuths tell everything of a distribution.
enum class Sector {
    All = 0,     ///< no symmetry
    Half = 2,    ///< mirrored in y
    Quarter = 4, ///< mirrored in x and in y
    Isotropic = 1
};

/// What some of the parts come to together, first to first + count - 1: their amplitudes stand for
/// the given mass (the integral over the sphere), or are merely multiplied by it.
struct Share {
    std::size_t first, count;
    double mass;
    bool normalised;
};

struct Distribution {
    std::vector<DistributionPart> parts;
    /// In this order still to be brought into the amplitudes, which takes integrals of the parts
    /// (Generator::weighted); empty in a distribution whose amplitudes are p's.
    std::vector<Share> shares;
    Sector sector = Sector::All;
    /// Names what it is, for people.
    std::string name;
};

inline constexpr std::size_t max_parts = 64;

/// Reads a specification (README.md, "Generating a BRDF from any distribution"). `source` names it
/// in messages, and the files it names are relative to it. Throws InputError naming the key.
Distribution parse_distribution(const std::string& text, const std::string& source);
Distribution read_distribution(const std::string& path);

/// A tabulated p(h) from .csv (columns theta_h, phi_h unless it is isotropic, p; a full grid) or
/// .exr (channel p or Y, rows over polar angles, columns over azimuths; their attributes theta_h,
/// phi_h list the nodes, otherwise rows go from 0 to pi/2 and columns round from 0). Throws
/// InputError naming the place where p is negative, not finite or 0 everywhere.
std::shared_ptr<const DirectionTable> read_tabulated(const std::string& path);

/// Throws InputError where the values are not finite, negative, or 0 everywhere; `source` begins
/// the message.
void check_values(const DirectionTable& table, const std::string& source);

} // namespace brdfit

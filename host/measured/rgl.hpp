#pragma once

#include "host/files/file.hpp"
#include "host/measured/samples.hpp"

#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// The tables of an RGL file, "An Adaptive Parameterization for Efficient Material Acquisition and
/// Rendering", Dupuy and Jakob 2018. With wi = a, the direction whose angles are the parameters,
/// wo = b and h between them, u(theta) = sqrt(2 theta / pi), v(phi) = (phi + pi) / (2 pi):
///
///     f(a, b) cos(theta_b) = table(x, y) ndf(u_h, v_h) / (4 sigma(u_a, v_a))
///
/// where (x, y) is what the warp makes of (u_h, v_h): y is the share of vndf below v_h, x that
/// below u_h along v_h. v_h counts from a's azimuth in isotropic files. Grids have their nodes on
/// the square's edges and are bilinear between them, linear over phi_i and theta_i.
struct RglTables {
    /// Values over the unit square, [y][x], x along u.
    struct Grid {
        std::size_t width = 0, height = 0; ///< at least 2
        std::vector<float> values;

        std::size_t count() const { return width * height; }
    };

    std::string description;
    std::vector<std::string> channels; ///< R, G, B or wavelengths in nm
    std::vector<float> phi_i, theta_i; ///< ascending, radians
    std::vector<float> wavelengths;    ///< nm; empty: R, G, B
    Grid ndf, sigma;                   ///< ndf >= 0, sigma > 0
    Grid vndf;                         ///< [phi_i][theta_i][y][x] >= 0, positive somewhere in each
    Grid table;                        ///< [phi_i][theta_i][channel][y][x]
    Grid luminance;                    ///< [phi_i][theta_i][y][x], the table's size; for samplers
    bool jacobian = true;              ///< false: the value is the table's alone

    bool isotropic() const { return phi_i.size() <= 2; }
    std::size_t slices() const { return phi_i.size() * theta_i.size(); }
    /// 2 or 4 where phi_i covers a half or a quarter of the circle, from -pi on: the rest is its
    /// point reflection or mirror image; otherwise 1.
    int reduction() const;
};

} // namespace brdfit

namespace brdfit::rgl {

bool recognise(std::string_view bytes);
/// Throws InputError naming field and byte.
RglTables read_tables(const MappedFile& file);
/// The values at the nodes of the table, each where the warp puts it: [phi_i][theta_i][y][x].
/// Weights are solid angles of wi times wo. Nodes below the horizon or on it are not valid.
Samples read(const MappedFile& file, std::optional<bool> isotropic);
/// Writes `rgb` where there are no wavelengths, otherwise `spectra` and `wavelengths`.
void write(const RglTables& tables, const std::string& path);

} // namespace brdfit::rgl

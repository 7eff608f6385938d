#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

using Rgb = std::array<double, 3>;

/// Light from all around: radiance in W/(m2 sr), constant within each texel. Rows are equal steps
/// of the angle from z, from the top; columns equal steps of azimuth, from left to right clockwise
/// seen from above, as one sees them from within; the middle looks along x. Twice as wide as high.
struct Environment {
    std::string name;                  ///< for people
    std::size_t width = 0, height = 0; ///< in texels
    std::vector<Rgb> texels;           ///< [row * width + column], >= 0

    /// Solid angle of a row's texels, sr.
    double solid_angle(std::size_t row) const;
    /// Integral of radiance over all directions.
    Rgb flux() const;
};

/// A latitude-longitude picture in an OpenEXR file: channels R, G, B, or Y alone. Throws InputError
/// naming the file where it is not twice as wide as high, has values that are negative, no numbers
/// or above 1e30, is black, or cannot be read.
Environment read_environment(const std::string& path);
/// A clear sky by CIE S 011 (2003), type 12, sun at 40 degrees elevation, over grey ground.
Environment sky_environment();
/// A dark studio with a large soft box above to the left, a strip to the right and a dim fill
/// light.
Environment soft_box_environment();
/// The same radiance, 1, from everywhere: a white furnace.
Environment even_environment();

/// One of these three by its name (softbox, sky, white), a latitude-longitude .exr, or none.
/// Throws UsageError for another name, InputError like read_environment.
std::optional<Environment> environment_named(const std::string& name);

/// Which texels to draw how often: the method of Walker 1977, built as by Vose 1991. A cell, drawn
/// evenly, is itself with probability own / 2^32, and otherwise texel `other`.
struct AliasTable {
    std::vector<std::uint32_t> own, other;
    /// Of the direction, by solid angle, in 1/sr: a texel's mean over channels, over its integral.
    std::vector<double> density;
};
AliasTable alias_table(const Environment& environment);

} // namespace brdfit

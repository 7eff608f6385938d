#pragma once

#include "host/files/text.hpp"
#include "host/measured/samples.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Measurements at any directions, given by polar angles in radians: one row a sample.
// Negative values are noise and valid; theta lies in [0, pi/2]. The data is isotropic when every
// phi_i is the same, unless the option says otherwise.

namespace brdfit::scattered {

/// Angles may exceed pi/2 by this much: the last digit of a rounded number. They are taken as pi/2.
inline constexpr double theta_tolerance = 1e-5;

/// Names of the four angle columns: of wi, then of wo.
struct Angles {
    std::string theta_i, phi_i, theta_o, phi_o;
};

/// Reads all rows from the next line on. `names` are the columns, in order: the four angles and one
/// for each channel, `weight` if there is one. Fields are separated as text::split takes it.
/// `lines` stands at the header, which is named when a column is missing.
Samples read_rows(text::Lines& lines, const std::vector<std::string_view>& names,
                  const Angles& angles, char separator, std::optional<bool> isotropic);

/// Whether the text begins with a line that names one of theta_i, phi_i, theta_o, phi_o.
bool recognise(std::string_view bytes);
/// CSV: a line of column names, then rows.
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::scattered

namespace brdfit::astm {

/// ASTM E1392 text: lines of keyword and value up to VARS, which names the columns; then rows.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::astm

namespace brdfit::cornell {

/// Cornell's spectral text: the number of wavelengths, the wavelengths, then rows of theta_i,
/// phi_i, theta_s, phi_s and one value a wavelength. Channels are named by wavelength.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::cornell

namespace brdfit::fred {

/// FRED's tabulated BSDF text: a line of the specular direction, theta and phi, then rows of theta,
/// phi and a value at that incidence. Negative theta lie across the normal. One channel.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::fred

namespace brdfit::zemax {

/// Zemax's tabular BSDF text: for each sample rotation and angle of incidence a table over azimuth
/// and radial angle about the specular direction. wi has the sample rotation as its azimuth; zeros
/// at the end of a row were not measured. Weights are solid angles of wi times wo. One channel, or
/// X, Y and Z.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

/// The angles of a file, ascending, in radians.
struct Grid {
    bool plane_symmetric = false; ///< azimuths stand for their mirror images too
    std::vector<double> rotations, incidences, azimuths, radials;

    std::size_t block() const { return azimuths.size() * radials.size(); }
    std::size_t blocks() const { return rotations.size() * incidences.size(); }
};

/// The grid that files are written on: incidences up to 85 degrees, radial angles from half a
/// degree about the specular direction to 180. Isotropic data is plane-symmetric and has one
/// rotation.
Grid written_grid(bool isotropic);
/// The grid's pairs, [rotation][incidence][azimuth][radial], below the horizon too.
Directions directions_of(const Grid& grid);
/// Writes values, [channel][pair], of one channel or of three, X, Y and Z. Each block's TIS is the
/// integral of f cos(theta_o) that the solid angles about the grid's nodes give. `provenance` lines
/// head it as `# ` lines.
void write(const Grid& grid, std::size_t channels, const std::vector<float>& values,
           const std::string& path, const std::vector<std::string>& provenance);

} // namespace brdfit::zemax

namespace brdfit::alta {

/// Text of the ALTA library: comments #DIM, #PARAM_IN and #PARAM_OUT say what the columns are.
/// Values with a cosine are divided by it; where it is below 1e-4 they become invalid.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::alta

namespace brdfit::utia {

/// The UTIA BRDF database's .bin (Filip and Vavra 2014): float64 [channel][wi][wo], 288 directions
/// each, [theta][phi] in steps of 15 and 7.5 degrees from 0. Known by its size alone.
inline constexpr std::size_t channels = 3, theta_nodes = 6, phi_nodes = 48,
                             directions = theta_nodes * phi_nodes;
inline constexpr double theta_step = 15 * degree, phi_step = 7.5 * degree;

/// Direction of one of the 288 nodes.
Vector node_direction(std::size_t node);
/// Whether all the bytes of a file are of that size.
bool recognise(std::string_view bytes);
/// The table, as the file has it.
std::vector<float> read_table(const MappedFile& file);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::utia

namespace brdfit::npy_samples {

/// NumPy arrays (N, 6 + channels + 1) of float32 or float64, as write_samples makes them: wi, wo,
/// one value a channel, weight. Channels are R,G,B where there are three, else numbered. Isotropic
/// where wi has azimuth 0 everywhere, unless the option says otherwise.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::npy_samples

namespace brdfit::npz_samples {

/// NumPy archives of the arrays wi (N, 3), wo (N, 3), values (N, channels) or (N,) and, where there
/// are any, weights (N,) and channels, the names; as write_samples makes them and numpy.savez and
/// savez_compressed do. Otherwise like .npy.
bool recognise(std::string_view bytes);
Samples read(const MappedFile& file, std::optional<bool> isotropic);

} // namespace brdfit::npz_samples

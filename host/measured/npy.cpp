#include "host/files/npy.hpp"
#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/rows.hpp"

#include <array>
#include <cfloat>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::npy_samples {

namespace {

constexpr std::size_t angles = 6; // columns wi_x,wi_y,wi_z,wo_x,wo_y,wo_z
constexpr double unit_tolerance = 1e-3, horizon_tolerance = 1e-5;

/// The unit vector in three columns, on or above the horizon.
Vector unit_vector(const MappedFile& file, const npy::Array& table, std::size_t row,
                   std::size_t column) {
    const char* const name = column == 0 ? "wi" : "wo";
    Vector v{table.at(row, column), table.at(row, column + 1), table.at(row, column + 2)};
    const double length = std::hypot(v[0], v[1], v[2]);
    if (!(std::abs(length - 1) <= unit_tolerance))
        throw InputError(
            fmt::format("{}: row {}: {} is not a unit vector", file.path(), row, name));
    for (double& x : v)
        x /= length;
    if (v[2] < -horizon_tolerance)
        throw InputError(
            fmt::format("{}: row {}: {} is below the horizon", file.path(), row, name));
    v[2] = std::max(v[2], 0.0);
    return v;
}

float finite(const MappedFile& file, const npy::Array& table, std::size_t row, std::size_t column) {
    const double value = table.at(row, column);
    if (!(std::abs(value) <= FLT_MAX))
        throw InputError(fmt::format("{}: row {}, column {}: {}; expected a finite number",
                                     file.path(), row, column, value));
    return static_cast<float>(value);
}

} // namespace

bool recognise(std::string_view head) {
    return npy::recognise(head);
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    const npy::Array table = npy::read(file);
    if (table.columns < angles + 2 || table.rows == 0)
        throw InputError(fmt::format(
            "{}: {} rows of {} columns; expected rows of wi_x,wi_y,wi_z,wo_x,wo_y,wo_z, one value "
            "a channel, weight",
            file.path(), table.rows, table.columns));
    const std::size_t channels = table.columns - angles - 1;
    if (channels > max_channels)
        throw InputError(fmt::format("{}: {} channels; expected at most {}", file.path(), channels,
                                     max_channels));
    Samples samples;
    samples.format = "NumPy array";
    samples.channels = numbered_channels(channels);
    Directions directions(table.rows);
    samples.values.resize(channels * table.rows);
    samples.weights.resize(table.rows);
    bool one_plane = true; // the writer turns isotropic data until wi lies at azimuth 0
    for (std::size_t k = 0; k < table.rows; ++k) {
        const Vector wi = unit_vector(file, table, k, 0), wo = unit_vector(file, table, k, 3);
        directions.set(k, wi, wo);
        one_plane = one_plane && wi[1] == 0 && wi[0] >= 0;
        for (std::size_t c = 0; c < channels; ++c)
            samples.values[c * table.rows + k] = finite(file, table, k, angles + c);
        samples.weights[k] = finite(file, table, k, angles + channels);
        if (samples.weights[k] < 0)
            throw InputError(fmt::format("{}: row {}: weight {}; expected 0 or more", file.path(),
                                         k, samples.weights[k]));
    }
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    samples.valid.assign(table.rows, 1);
    samples.isotropic = isotropic.value_or(one_plane);
    return samples;
}

} // namespace brdfit::npy_samples

#include "host/files/npy.hpp"
#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/files/text.hpp"
#include "host/files/zip.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/rows.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <fmt/format.h>
#include <set>

namespace brdfit {

namespace {

constexpr double unit_tolerance = 1e-3, horizon_tolerance = 1e-5;

/// Neighbouring columns of an array, from `first` on.
struct Columns {
    const npy::Array& array;
    std::size_t first = 0, count = 0;

    double at(std::size_t row, std::size_t column) const { return array.at(row, first + column); }
};

/// Where samples are in arrays of as many rows.
struct SampleColumns {
    Columns wi, wo, values;
    std::optional<Columns> weights;
};

/// The unit vector in three columns, on or above the horizon.
Vector unit_vector(const std::string& path, const Columns& columns, std::size_t row,
                   const char* name) {
    Vector v{columns.at(row, 0), columns.at(row, 1), columns.at(row, 2)};
    const double length = std::hypot(v[0], v[1], v[2]);
    if (!(std::abs(length - 1) <= unit_tolerance))
        throw InputError(fmt::format("{}: row {}: {} is not a unit vector", path, row, name));
    for (double& x : v)
        x /= length;
    if (v[2] < -horizon_tolerance)
        throw InputError(fmt::format("{}: row {}: {} is below the horizon", path, row, name));
    v[2] = std::max(v[2], 0.0);
    return v;
}

float finite(const std::string& path, const Columns& columns, std::size_t row, std::size_t column) {
    const double value = columns.at(row, column);
    if (!(std::abs(value) <= FLT_MAX))
        throw InputError(fmt::format("{}: row {}, column {}: {}; expected a finite number", path,
                                     row, columns.first + column, value));
    return static_cast<float>(value);
}

Samples read_rows(const std::string& path, const SampleColumns& columns,
                  std::optional<bool> isotropic) {
    const std::size_t rows = columns.wi.array.rows, channels = columns.values.count;
    if (channels > max_channels)
        throw InputError(
            fmt::format("{}: {} channels; expected at most {}", path, channels, max_channels));
    Samples samples;
    samples.channels = numbered_channels(channels);
    Directions directions(rows);
    samples.values.resize(channels * rows);
    if (columns.weights)
        samples.weights.resize(rows);
    bool one_plane = true; // the writer turns isotropic data until wi lies at azimuth 0
    for (std::size_t k = 0; k < rows; ++k) {
        const Vector wi = unit_vector(path, columns.wi, k, "wi"),
                     wo = unit_vector(path, columns.wo, k, "wo");
        directions.set(k, wi, wo);
        one_plane = one_plane && wi[1] == 0 && wi[0] >= 0;
        for (std::size_t c = 0; c < channels; ++c)
            samples.values[c * rows + k] = finite(path, columns.values, k, c);
        if (!columns.weights)
            continue;
        samples.weights[k] = finite(path, *columns.weights, k, 0);
        if (samples.weights[k] < 0)
            throw InputError(fmt::format("{}: row {}: weight {}; expected 0 or more", path, k,
                                         samples.weights[k]));
    }
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    samples.valid.assign(rows, 1);
    samples.isotropic = isotropic.value_or(one_plane);
    return samples;
}

/// An archive's arrays, unpacked when asked for.
class Archive {
  public:
    explicit Archive(const MappedFile& file) : file_(file), members_(zip::directory(file)) {}

    bool has(const std::string& name) const { return find(name) != members_.end(); }
    std::string name_of(const std::string& name) const {
        return fmt::format("{}: {}", file_.path(), name);
    }
    /// The bytes of an array, which stay in `buffer` where they were packed.
    std::string_view bytes(const std::string& name, std::string& buffer) const {
        const auto member = find(name);
        if (member == members_.end())
            throw InputError(fmt::format("{}: has no array {}; expected wi, wo and values, and "
                                         "maybe weights and channels",
                                         file_.path(), name));
        return zip::unpack(file_, *member, buffer);
    }

  private:
    std::vector<zip::Member>::const_iterator find(const std::string& name) const {
        return std::find_if(members_.begin(), members_.end(), [&](const zip::Member& member) {
            return member.name == name + ".npy";
        });
    }
    const MappedFile& file_;
    std::vector<zip::Member> members_;
};

} // namespace

namespace npy_samples {

bool recognise(std::string_view head) {
    return npy::recognise(head);
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    constexpr std::size_t angles = 6; // columns wi_x,wi_y,wi_z,wo_x,wo_y,wo_z
    const npy::Array table = npy::read(file);
    if (table.columns < angles + 2 || table.rows == 0)
        throw InputError(fmt::format(
            "{}: {} rows of {} columns; expected rows of wi_x,wi_y,wi_z,wo_x,wo_y,wo_z, one value "
            "a channel, weight",
            file.path(), table.rows, table.columns));
    const SampleColumns columns{{table, 0, 3},
                                {table, 3, 3},
                                {table, angles, table.columns - angles - 1},
                                Columns{table, table.columns - 1, 1}};
    Samples samples = read_rows(file.path(), columns, isotropic);
    samples.format = "NumPy array";
    return samples;
}

} // namespace npy_samples

namespace npz_samples {

bool recognise(std::string_view head) {
    return zip::recognise(head);
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    const Archive archive(file);
    std::string of_wi, of_wo, of_values, of_weights, of_channels; // unpacked
    const auto array = [&](const std::string& name, std::string& buffer, bool column) {
        return npy::read(archive.bytes(name, buffer), archive.name_of(name), column);
    };
    const npy::Array wi = array("wi", of_wi, false);
    const auto require_shape = [&](const std::string& name, const npy::Array& of,
                                   std::size_t columns) {
        if (of.rows != wi.rows || of.rows == 0 || of.columns != columns)
            throw InputError(fmt::format("{}: {} x {}; expected {} x {}", archive.name_of(name),
                                         of.rows, of.columns, std::max<std::size_t>(wi.rows, 1),
                                         columns));
    };
    require_shape("wi", wi, 3);
    const npy::Array wo = array("wo", of_wo, false);
    require_shape("wo", wo, 3);
    const npy::Array values = array("values", of_values, true);
    require_shape("values", values, std::max<std::size_t>(values.columns, 1));
    npy::Array weights;
    SampleColumns columns{{wi, 0, 3}, {wo, 0, 3}, {values, 0, values.columns}, std::nullopt};
    if (archive.has("weights")) {
        weights = array("weights", of_weights, true);
        require_shape("weights", weights, 1);
        columns.weights.emplace(Columns{weights, 0, 1});
    }
    Samples samples = read_rows(file.path(), columns, isotropic);
    samples.format = "NumPy archive";
    if (!archive.has("channels"))
        return samples;
    samples.channels =
        npy::read_texts(archive.bytes("channels", of_channels), archive.name_of("channels"));
    if (samples.channels.size() != values.columns)
        throw InputError(fmt::format("{}: {} names; expected {}, as many as values has columns",
                                     archive.name_of("channels"), samples.channels.size(),
                                     values.columns));
    std::set<std::string> seen;
    for (const std::string& name : samples.channels)
        if (!is_channel_name(name) || !seen.insert(name).second)
            throw InputError(fmt::format("{}: {}; expected {}, each once",
                                         archive.name_of("channels"), text::quoted(name),
                                         channel_name_expected));
    return samples;
}

} // namespace npz_samples

} // namespace brdfit

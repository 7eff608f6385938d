#include "host/measured/rgl.hpp"

#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/measured/rows.hpp"
#include "host/measured/tensor_file.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <numeric>

namespace brdfit::rgl {

namespace {

using tensor_file::Field;
using tensor_file::Type;

constexpr float most_theta = 1.5708F;    // pi/2 rounded up
constexpr std::size_t most_nodes = 4096; // along an axis of a grid

/// Whether to take the values of the largest fields, or to check them alone.
enum class Values { Taken, Checked };

/// Value `i` of an array in the file, which is not aligned.
float stored(std::string_view data, std::size_t i) {
    float value;
    std::memcpy(&value, data.data() + i * sizeof value, sizeof value);
    return value;
}

/// The fields of a file by name, and what is wrong with them.
class Fields {
  public:
    explicit Fields(const MappedFile& file) : path_(file.path()), all_(tensor_file::read(file)) {}

    const Field* find(std::string_view name) const {
        const auto found = std::find_if(all_.begin(), all_.end(),
                                        [&](const Field& field) { return field.name == name; });
        return found == all_.end() ? nullptr : &*found;
    }
    /// A field of that type and number of dimensions.
    const Field& get(std::string_view name, Type type, std::size_t dimensions) const {
        const Field* const field = find(name);
        if (field == nullptr)
            throw InputError(fmt::format("{}: no field '{}'; expected an RGL BRDF", path_, name));
        if (field->type != type)
            fail(*field, fmt::format("type {}; expected {}", static_cast<int>(field->type),
                                     type == Type::U8 ? "1, uint8" : "10, float32"));
        if (field->shape.size() != dimensions)
            fail(*field,
                 fmt::format("{} dimensions; expected {}", field->shape.size(), dimensions));
        return *field;
    }
    /// Fails unless the float32 values of a field are finite and at least `least`.
    void check(const Field& field, float least = -INFINITY) const {
        for (std::size_t i = 0; i < field.count(); ++i)
            if (const float value = stored(field.data, i); !std::isfinite(value) || value < least)
                fail_value(field, i, value,
                           least == 0 ? "a finite number, 0 or more" : "a finite number");
    }
    std::vector<float> floats(const Field& field, float least = -INFINITY) const {
        check(field, least);
        std::vector<float> values(field.count());
        if (!values.empty())
            std::memcpy(values.data(), field.data.data(), field.data.size());
        return values;
    }
    [[noreturn]] void fail(const Field& field, std::string_view message) const {
        throw InputError(
            fmt::format("{}: field '{}' at byte {}: {}", path_, field.name, field.offset, message));
    }
    [[noreturn]] void fail_value(const Field& field, std::size_t i, float value,
                                 std::string_view expected) const {
        throw InputError(fmt::format("{}: field '{}', byte {}: {}; expected {}", path_, field.name,
                                     field.offset + i * sizeof value, value, expected));
    }

  private:
    const std::string& path_;
    std::vector<Field> all_;
};

std::vector<float> ascending(const Fields& fields, const char* name) {
    const Field& field = fields.get(name, Type::F32, 1);
    const std::vector<float> values = fields.floats(field);
    if (values.empty())
        fields.fail(field, "no values; expected at least one");
    for (std::size_t i = 1; i < values.size(); ++i)
        if (!(values[i] > values[i - 1]))
            fields.fail_value(field, i, values[i], "values that ascend");
    return values;
}

/// A grid of `field`, whose last two axes are y and x and whose first ones are `outer`.
RglTables::Grid grid_of(const Fields& fields, const Field& field,
                        const std::vector<std::size_t>& outer, float least = -INFINITY,
                        Values values = Values::Taken) {
    if (!std::equal(outer.begin(), outer.end(), field.shape.begin()))
        fields.fail(field, fmt::format("shape {}; expected {} as the others say",
                                       fmt::join(field.shape, " x "), fmt::join(outer, " x ")));
    RglTables::Grid grid;
    grid.height = field.shape[outer.size()];
    grid.width = field.shape[outer.size() + 1];
    for (const std::size_t nodes : {grid.height, grid.width})
        if (nodes < 2 || nodes > most_nodes)
            fields.fail(field, fmt::format("{} x {} nodes; expected 2 to {} along each axis",
                                           grid.height, grid.width, most_nodes));
    if (values == Values::Taken)
        grid.values = fields.floats(field, least);
    else
        fields.check(field, least);
    return grid;
}

/// The field of f cos(theta_b).
const Field& table_field(const Fields& fields) {
    return fields.get(fields.find("spectra") != nullptr ? "spectra" : "rgb", Type::F32, 5);
}

void read_channels(const Fields& fields, Values values, RglTables& tables) {
    const Field& field = table_field(fields);
    if (field.name == "spectra") {
        tables.wavelengths = ascending(fields, "wavelengths");
        for (const float wavelength : tables.wavelengths)
            tables.channels.push_back(fmt::format("{}", wavelength));
    } else {
        tables.channels = {"R", "G", "B"};
    }
    if (tables.channels.size() > max_channels)
        fields.fail(field, fmt::format("{} channels; expected at most {}", tables.channels.size(),
                                       max_channels));
    tables.table =
        grid_of(fields, field, {tables.phi_i.size(), tables.theta_i.size(), tables.channels.size()},
                -INFINITY, values);
}

/// All tables. Those that are not taken, the table's and the luminance, have sizes alone.
RglTables tables_of(const Fields& fields, Values values) {
    RglTables tables;
    tables.phi_i = ascending(fields, "phi_i");
    tables.theta_i = ascending(fields, "theta_i");
    const Field& theta_i = fields.get("theta_i", Type::F32, 1);
    for (const std::size_t i : {std::size_t{0}, tables.theta_i.size() - 1})
        if (tables.theta_i[i] < 0 || tables.theta_i[i] > most_theta)
            fields.fail_value(theta_i, i, tables.theta_i[i], "an angle in [0, pi/2]");
    const Field& description = fields.get("description", Type::U8, 1);
    tables.description = std::string(description.data);
    const Field& jacobian = fields.get("jacobian", Type::U8, 1);
    if (jacobian.count() != 1)
        fields.fail(jacobian, fmt::format("{} values; expected 1", jacobian.count()));
    tables.jacobian = jacobian.data[0] != 0;
    tables.ndf = grid_of(fields, fields.get("ndf", Type::F32, 2), {}, 0);
    const Field& sigma = fields.get("sigma", Type::F32, 2);
    tables.sigma = grid_of(fields, sigma, {});
    for (std::size_t i = 0; i < tables.sigma.values.size(); ++i)
        if (!(tables.sigma.values[i] > 0))
            fields.fail_value(sigma, i, tables.sigma.values[i], "a positive number");
    const std::vector<std::size_t> parameters{tables.phi_i.size(), tables.theta_i.size()};
    const Field& vndf = fields.get("vndf", Type::F32, 4);
    tables.vndf = grid_of(fields, vndf, parameters, 0);
    for (std::size_t slice = 0; slice < tables.slices(); ++slice) {
        const auto begin =
            tables.vndf.values.begin() + static_cast<std::ptrdiff_t>(slice * tables.vndf.count());
        if (std::all_of(begin, begin + static_cast<std::ptrdiff_t>(tables.vndf.count()),
                        [](float x) { return x == 0; }))
            fields.fail_value(vndf, slice * tables.vndf.count(), 0,
                              "a positive value in each slice");
    }
    read_channels(fields, values, tables);
    tables.luminance =
        grid_of(fields, fields.get("luminance", Type::F32, 4), parameters, 0, values);
    return tables;
}

/// One density over the unit square, as its table is inverted.
class Slice {
  public:
    Slice(const float* values, std::size_t width, std::size_t height)
        : values_(values), width_(width), rows_(height), marginal_(height) {
        for (std::size_t y = 0; y < height; ++y) {
            for (std::size_t x = 0; x + 1 < width; ++x)
                rows_[y] += (static_cast<double>(at(x, y)) + at(x + 1, y)) / 2;
            if (y > 0)
                marginal_[y] = marginal_[y - 1] + (rows_[y - 1] + rows_[y]) / 2;
        }
    }

    struct Point {
        double u, v;    ///< in [0, 1]
        double density; ///< of the warp, whose integral over the square is 1
    };
    /// What the warp makes of a point (x, y) of the unit square.
    Point at_share(double x, double y) const {
        // The row: below it lies the share y of all.
        double rest = y * marginal_.back();
        std::size_t row = 0;
        while (row + 2 < rows_.size() && marginal_[row + 1] < rest)
            ++row;
        const double v = along(rows_[row], rows_[row + 1], rest - marginal_[row]);
        // Along it the same.
        const auto across = [&](std::size_t column) {
            return (1 - v) * at(column, row) + v * at(column, row + 1);
        };
        rest = x * ((1 - v) * rows_[row] + v * rows_[row + 1]);
        std::size_t column = 0;
        double left = across(0), right = across(1);
        while (column + 2 < width_ && (left + right) / 2 < rest) {
            rest -= (left + right) / 2;
            left = right;
            right = across(++column + 1);
        }
        const double u = along(left, right, rest);
        const double cells = static_cast<double>((width_ - 1) * (rows_.size() - 1));
        return {(static_cast<double>(column) + u) / static_cast<double>(width_ - 1),
                (static_cast<double>(row) + v) / static_cast<double>(rows_.size() - 1),
                ((1 - u) * left + u * right) * cells / marginal_.back()};
    }

  private:
    float at(std::size_t x, std::size_t y) const { return values_[y * width_ + x]; }
    /// Where in [0, 1] the integral of a density that goes from a to b is `integral`.
    static double along(double a, double b, double integral) {
        const double t = std::max(integral, 0.0);
        const double root = a + std::sqrt(std::max(a * a + 2 * (b - a) * t, 0.0));
        return root > 0 ? std::min(2 * t / root, 1.0) : 0;
    }
    const float* values_;
    std::size_t width_;
    std::vector<double> rows_, marginal_; // integrals along each row, and over all before it
};

double bilinear(const RglTables::Grid& grid, double u, double v) {
    const auto cell = [](double x, std::size_t nodes) {
        const double at = x * static_cast<double>(nodes - 1);
        const auto i = std::min(static_cast<std::size_t>(at), nodes - 2);
        return std::pair(i, at - static_cast<double>(i));
    };
    const auto [x, s] = cell(u, grid.width);
    const auto [y, t] = cell(v, grid.height);
    const float* const at = grid.values.data() + y * grid.width + x;
    return (1 - t) * ((1 - s) * at[0] + s * at[1]) +
           t * ((1 - s) * at[grid.width] + s * at[grid.width + 1]);
}

double to_u(double theta) {
    return std::sqrt(2 * theta / pi);
}

/// The part of the unit interval that node i of n is nearest to.
double share(std::size_t i, std::size_t n) {
    return (i == 0 || i + 1 == n ? 0.5 : 1.0) / static_cast<double>(n - 1);
}

/// Solid angle of the incident directions that slice (p, t) is nearest to.
double incident_measure(const RglTables& tables, std::size_t p, std::size_t t) {
    const std::vector<double> theta(tables.theta_i.begin(), tables.theta_i.end()),
        phi(tables.phi_i.begin(), tables.phi_i.end());
    const auto [least, most] = ranges_of(theta, 0, pi / 2)[t];
    double turn = 2 * pi / static_cast<double>(phi.size());
    if (!tables.isotropic()) {
        const auto [begin, end] = ranges_of(phi, phi.front(), phi.back())[p];
        turn = end - begin;
    }
    return turn * (std::cos(least) - std::cos(most));
}

/// A node of a table that is a sample.
struct Node {
    std::size_t x, y;
    Slice::Point at; ///< where the warp puts it
    Vector h, wo;
    double c; ///< wi.h
};

/// Slice (p, t) of the tables.
struct Incidence {
    Incidence(const RglTables& tables, std::size_t slice)
        : tables(tables), slice(slice), p(slice / tables.theta_i.size()),
          t(slice % tables.theta_i.size()), theta(std::min<double>(tables.theta_i[t], pi / 2)),
          phi(tables.phi_i[p]), wi(direction(theta, phi)) {}

    /// Calls body(node) for each whose directions are above the horizon: also as the float32 planes
    /// have them, by more than their rounding.
    template <typename Body>
    void each_node(Body body) const {
        const RglTables::Grid& table = tables.table;
        const Slice warp(tables.vndf.values.data() + slice * tables.vndf.count(), tables.vndf.width,
                         tables.vndf.height);
        if (!(wi[2] > 1e-6))
            return;
        for (std::size_t y = 0; y < table.height; ++y)
            for (std::size_t x = 0; x < table.width; ++x) {
                const auto at =
                    warp.at_share(static_cast<double>(x) / static_cast<double>(table.width - 1),
                                  static_cast<double>(y) / static_cast<double>(table.height - 1));
                const Vector h = direction(at.u * at.u * pi / 2,
                                           (2 * at.v - 1) * pi + (tables.isotropic() ? phi : 0.0));
                const double c = wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2];
                const Vector wo{2 * c * h[0] - wi[0], 2 * c * h[1] - wi[1], 2 * c * h[2] - wi[2]};
                if (c > 0 && wo[2] > 1e-6)
                    body(Node{x, y, at, h, wo, c});
            }
    }

    const RglTables& tables;
    const std::size_t slice, p, t;
    const double theta, phi;
    const Vector wi;
};

/// Sets the samples of a slice, from sample `k` on. `values`: the bytes of the table.
void set_samples(const Incidence& incidence, std::string_view values, std::size_t k,
                 Directions& directions, Samples& samples) {
    const RglTables& tables = incidence.tables;
    const RglTables::Grid& table = tables.table;
    const std::size_t nodes = table.count(), channels = tables.channels.size(),
                      count = directions.count();
    const double area = 4 * bilinear(tables.sigma, to_u(incidence.theta),
                                     std::min(std::max((incidence.phi + pi) / (2 * pi), 0.0), 1.0));
    const double measure = incident_measure(tables, incidence.p, incidence.t);
    incidence.each_node([&](const Node& node) {
        const Slice::Point& at = node.at;
        directions.set(k, incidence.wi, node.wo, node.h, node.c);
        samples.valid[k] = 1;
        const double factor =
            (tables.jacobian ? bilinear(tables.ndf, at.u, at.v) / area : 1) / node.wo[2];
        const std::size_t at_node =
            incidence.slice * channels * nodes + node.y * table.width + node.x;
        for (std::size_t ch = 0; ch < channels; ++ch) {
            const double value = factor * stored(values, at_node + ch * nodes);
            samples.valid[k] &= static_cast<std::uint8_t>(std::abs(value) <= FLT_MAX);
            samples.values[ch * count + k] = static_cast<float>(value);
        }
        // d(wo) = 4 c d(h), d(h) = 2 pi^2 u sin(theta_h) du dv
        const double theta_h = at.u * at.u * pi / 2;
        const double outgoing = at.density > 0 ? share(node.x, table.width) *
                                                     share(node.y, table.height) / at.density * 8 *
                                                     pi * pi * at.u * std::sin(theta_h) * node.c
                                               : 0;
        samples.weights[k++] = static_cast<float>(std::min<double>(measure * outgoing, FLT_MAX));
    });
}

} // namespace

bool recognise(std::string_view bytes) {
    return tensor_file::recognise(bytes);
}

RglTables read_tables(const MappedFile& file) {
    return tables_of(Fields(file), Values::Taken);
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    const Fields fields(file);
    const RglTables tables = tables_of(fields, Values::Checked);
    const std::string_view values = table_field(fields).data;
    if (isotropic && *isotropic != tables.isotropic())
        throw UsageError(fmt::format("{}: the RGL file says that it is {}isotropic", file.path(),
                                     tables.isotropic() ? "" : "an"));
    Samples samples;
    samples.format = fmt::format("RGL tensor file, values with cos(theta_o){}",
                                 tables.wavelengths.empty() ? "" : ", spectral");
    samples.channels = tables.channels;
    samples.isotropic = tables.isotropic();
    const std::size_t slices = tables.slices();
    std::vector<std::size_t> first(slices + 1); // sample of each slice
    parallel_pieces(slices, 1, [&](std::size_t slice, std::size_t) {
        Incidence(tables, slice).each_node([&](const Node&) { ++first[slice + 1]; });
    });
    std::partial_sum(first.begin(), first.end(), first.begin());
    const std::size_t count = first.back();
    if (count == 0)
        throw InputError(fmt::format("{}: all directions are below the horizon; expected some "
                                     "above",
                                     file.path()));
    samples.left_out = slices * tables.table.count() - count;
    Directions directions = Directions::unfilled(count);
    samples.values.resize(count * tables.channels.size());
    samples.weights.resize(count);
    samples.valid.resize(count);
    parallel_pieces(slices, 1, [&](std::size_t slice, std::size_t) {
        set_samples(Incidence(tables, slice), values, first[slice], directions, samples);
    });
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    return samples;
}

void write(const RglTables& tables, const std::string& path) {
    const auto field = [](const char* name, std::vector<std::size_t> shape,
                          const std::vector<float>& values) {
        Field made{name, Type::F32, std::move(shape), 0, {}};
        made.data = {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
        return made;
    };
    const std::size_t p = tables.phi_i.size(), t = tables.theta_i.size();
    const RglTables::Grid &ndf = tables.ndf, &sigma = tables.sigma, &vndf = tables.vndf,
                          &table = tables.table, &luminance = tables.luminance;
    const bool rgb = tables.wavelengths.empty();
    const char jacobian = tables.jacobian ? 1 : 0;
    std::vector<Field> fields{
        {"description", Type::U8, {tables.description.size()}, 0, tables.description},
        field("phi_i", {p}, tables.phi_i),
        field("theta_i", {t}, tables.theta_i),
        field("sigma", {sigma.height, sigma.width}, sigma.values),
        field("ndf", {ndf.height, ndf.width}, ndf.values),
        field("vndf", {p, t, vndf.height, vndf.width}, vndf.values),
        field("luminance", {p, t, luminance.height, luminance.width}, luminance.values),
        field(rgb ? "rgb" : "spectra", {p, t, tables.channels.size(), table.height, table.width},
              table.values),
        {"jacobian", Type::U8, {1}, 0, {&jacobian, 1}}};
    if (!rgb)
        fields.push_back(field("wavelengths", {tables.wavelengths.size()}, tables.wavelengths));
    tensor_file::write(path, fields);
}

} // namespace brdfit::rgl

namespace brdfit {

int RglTables::reduction() const {
    if (isotropic())
        return 1;
    const double turns = std::round(2 * pi / (static_cast<double>(phi_i.back()) - phi_i.front()));
    return turns >= 4 ? 4 : turns >= 2 ? 2 : 1;
}

} // namespace brdfit

#include "fit/python/arrays.hpp"
#include "fit/python/call.hpp"
#include "fit/python/module.hpp"
#include "host/error.hpp"
#include "host/microfacet/generator.hpp"
#include "host/table/table.hpp"

#include <fmt/format.h>
#include <memory>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>
#include <tuple>
#include <utility>

// Tables for renderers, and tables of distributions.

namespace brdfit::python {

namespace {

/// What replaces parts of a preset or a specification; see the options of brdfit table.
struct Changes {
    std::string model, encoding; ///< empty: as they are
    double tolerance = 0;        ///< 0: as it is
    std::size_t size = 0;        ///< 0: as they are
    std::map<std::string, double> parameters;
};

Encoding encoding_named(const std::string& name) {
    for (const auto& [known, encoding] : {std::pair{"float", Encoding::Float},
                                          {"half", Encoding::Half},
                                          {"unorm16", Encoding::Unorm16}})
        if (name == known)
            return encoding;
    throw InputError(fmt::format("encoding: '{}'; expected float, half or unorm16", name));
}

TableSpec changed(TableSpec spec, const Changes& changes) {
    if (!changes.model.empty())
        set_model(spec, model_named(changes.model));
    for (const auto& [name, value] : changes.parameters)
        set_parameter(spec, name, value);
    if (changes.size > 0)
        set_size(spec, changes.size);
    if (changes.tolerance > 0)
        spec.tolerance = changes.tolerance;
    if (!changes.encoding.empty())
        spec.encoding = encoding_named(changes.encoding);
    return spec;
}

TableSpec preset_named(const std::string& name) {
    if (const TableSpec* const preset = find_preset(name))
        return *preset;
    std::string names;
    for (const Preset& preset : presets())
        names += (names.empty() ? "" : ", ") + preset.name;
    throw InputError(fmt::format("'{}' is neither a preset nor a specification (a dict, or the "
                                 "path of a .json); presets: {}",
                                 name, names));
}

/// [value][slowest axis]...[fastest axis].
DoubleArray values_of(const Table& table) {
    Shape shape;
    for (auto axis = table.spec.axes.rbegin(); axis != table.spec.axes.rend(); ++axis)
        shape.push_back(axis->size);
    return to_array(table.values, shape);
}

// Name, nodes and mapping of each axis.
std::vector<std::tuple<std::string, DoubleArray, std::string>> axes_of(const Table& table) {
    std::vector<std::tuple<std::string, DoubleArray, std::string>> axes;
    for (const Axis& axis : table.spec.axes) {
        std::vector<double> nodes(axis.size);
        for (std::size_t i = 0; i < axis.size; ++i)
            nodes[i] = axis.value(i);
        axes.emplace_back(axis.name(), to_array(std::move(nodes), {axis.size}), axis.mapping());
    }
    return axes;
}

void add_table(nb::module_& module) {
    nb::class_<Changes>(module, "Changes")
        .def(nb::init<>())
        .def_rw("model", &Changes::model)
        .def_rw("encoding", &Changes::encoding)
        .def_rw("tolerance", &Changes::tolerance)
        .def_rw("size", &Changes::size)
        .def_rw("parameters", &Changes::parameters);
    nb::class_<Table>(module, "RenderTable")
        .def("values", &values_of)
        .def("axes", &axes_of)
        .def("provenance", [](const Table& table) { return provenance(table); })
        .def_prop_ro("channels", [](const Table& table) { return table.spec.channels; })
        .def_prop_ro("error", [](const Table& table) { return table.error; })
        .def(
            "save",
            [](const Table& table, const std::string& path, bool clamp) {
                return write_table(table, path, clamp);
            },
            nb::arg("path"), nb::arg("clamp"));
    module.def(
        "table",
        [](const std::string& what, bool preset, const std::string& source, const Changes& changes,
           const std::string& device, const nb::object& progress) {
            return run(progress, [&](Call& call) {
                const TableSpec spec =
                    changed(preset ? preset_named(what) : parse_table_spec(what, source), changes);
                return std::make_unique<Table>(
                    compute_table(opened(device), spec, call.progress()));
            });
        },
        nb::arg("what"), nb::arg("preset"), nb::arg("source"), nb::arg("changes"),
        nb::arg("device"), nb::arg("progress").none());
    module.def("presets", [] {
        std::vector<std::pair<std::string, std::string>> all;
        for (const Preset& preset : presets())
            all.emplace_back(preset.name, preset.renderer);
        return all;
    });
}

void add_generator(nb::module_& module) {
    // Planes [row][column] over elevations and azimuths.
    nb::class_<MicrofacetTable>(module, "GeneratedTable")
        .def_prop_ro("name", [](const MicrofacetTable& t) { return t.distribution.name; })
        .def_prop_ro("isotropic", [](const MicrofacetTable& t) { return t.isotropic(); })
        .def_prop_ro("mean",
                     [](const MicrofacetTable& t) {
                         return std::vector<double>(t.mean.begin(), t.mean.end());
                     })
        .def_ro("mean_height", &MicrofacetTable::mean_height)
        .def("elevations",
             [](const MicrofacetTable& t) {
                 std::vector<double> nodes(t.grid.rows);
                 for (std::size_t r = 0; r < nodes.size(); ++r)
                     nodes[r] = t.grid.elevation(static_cast<double>(r));
                 return to_array(std::move(nodes), {t.grid.rows});
             })
        .def("azimuths",
             [](const MicrofacetTable& t) {
                 std::vector<double> nodes(t.grid.columns);
                 for (std::size_t c = 0; c < nodes.size(); ++c)
                     nodes[c] = t.grid.azimuth(static_cast<double>(c));
                 return to_array(std::move(nodes), {t.grid.columns});
             })
        .def("g",
             [](const MicrofacetTable& t) {
                 return to_array(std::vector<float>(t.g), {t.grid.rows, t.grid.columns});
             })
        .def(
            "reflectance",
            [](const MicrofacetTable& t, int f0, bool correlated) {
                return to_array(std::vector<float>(t.reflectance(f0, correlated)),
                                {t.grid.rows, t.grid.columns});
            },
            nb::arg("f0"), nb::arg("correlated"))
        .def(
            "save", [](const MicrofacetTable& t, const std::string& path) { write_table(t, path); },
            nb::arg("path"));
    module.def(
        "generate",
        [](const std::string& text, const std::string& source, std::size_t points, bool lambertian,
           const std::string& device, const nb::object& progress) {
            return run(progress, [&](Call& call) {
                if (points < least_points || points > most_points)
                    throw InputError(fmt::format("points: {}; expected {} to {}", points,
                                                 least_points, most_points));
                GeneratorOptions options;
                options.points = points;
                options.facets = lambertian;
                const Distribution distribution = parse_distribution(text, source);
                return std::make_unique<MicrofacetTable>(
                    Generator(opened(device))
                        .generate(distribution, options, source, call.progress()));
            });
        },
        nb::arg("text"), nb::arg("source"), nb::arg("points"), nb::arg("lambertian"),
        nb::arg("device"), nb::arg("progress").none());
}

} // namespace

void add_tables(nb::module_& module) {
    add_table(module);
    add_generator(module);
}

} // namespace brdfit::python

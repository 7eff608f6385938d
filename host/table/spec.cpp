#include "host/table/table.hpp"

#include "host/albedo/integrator.hpp"
#include "host/error.hpp"
#include "host/files/json.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <set>

namespace brdfit {

namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 20;
constexpr const char* expected_file = "a table's specification";

bool is_identifier(const std::string& name) {
    return !name.empty() && name.size() <= 100 &&
           std::isdigit(static_cast<unsigned char>(name[0])) == 0 &&
           std::all_of(name.begin(), name.end(),
                       [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

/// `parameter:NAME`: sets kind, parameter and the range, all that the catalogue lets it have.
void parse_parameter_axis(const std::string& name, const Place& at, const Model& model,
                          Axis& axis) {
    std::string known;
    for (const Parameter* p : own_parameters(model)) {
        known += (known.empty() ? "parameter:" : ", parameter:") + p->name;
        if (name != p->name)
            continue;
        axis.kind = AxisKind::Parameter;
        axis.parameter = name;
        axis.lower = p->lower;
        axis.upper = p->upper;
        return;
    }
    at.fail(Json("parameter:" + name),
            fmt::format("a parameter of {} beside roughness and f0, which have axes of their own: "
                        "{}",
                        model.name, known.empty() ? "it has none" : known));
}

Axis parse_axis(const Json& json, const Place& at, const Model& model) {
    check_object(json, at, "an object that describes an axis");
    Axis axis;
    const Json& kind = required(json, at, "axis", "the name of an axis");
    const std::string prefix = "parameter:";
    if (kind.is_string() && kind.get<std::string>().rfind(prefix, 0) == 0)
        parse_parameter_axis(kind.get<std::string>().substr(prefix.size()), at.member("axis"),
                             model, axis);
    else
        axis.kind = parse_choice<AxisKind>(kind, at.member("axis"),
                                           {{"cos_theta", AxisKind::CosTheta},
                                            {"roughness", AxisKind::Roughness},
                                            {"f0", AxisKind::F0},
                                            {"ior", AxisKind::Ior},
                                            {"parameter:NAME", AxisKind::Parameter}});
    std::vector<std::string> keys{"axis", "size", "nodes", "power", "least", "range"};
    if (axis.kind == AxisKind::Ior)
        keys.emplace_back("mapping");
    check_keys(json, at, keys);
    const Json& size = required(json, at, "size", "the number of nodes");
    const double nodes = parse_number(size, at.member("size"), 2, largest_size);
    if (nodes != std::floor(nodes))
        at.member("size").fail(size, "a whole number");
    axis.size = static_cast<std::size_t>(nodes);
    if (const Json* const value = optional(json, "nodes"))
        axis.nodes = parse_choice<Nodes>(*value, at.member("nodes"),
                                         {{"corners", Nodes::Corners},
                                          {"centres", Nodes::Centres},
                                          {"descending", Nodes::Descending}});
    if (const Json* const value = optional(json, "power"))
        axis.power = parse_number(*value, at.member("power"), 0.1, 10);
    if (const Json* const value = optional(json, "least"))
        axis.least = parse_number(*value, at.member("least"), 0, 1);
    if (const Json* const value = optional(json, "mapping")) {
        axis.reciprocal =
            parse_choice<bool>(*value, at.member("mapping"), {{"power", false}, {"openpbr", true}});
        if (axis.reciprocal && (axis.size % 2 != 0 || axis.size < 4))
            at.member("size").fail(size, "an even number of at least 4 for the mapping openpbr");
    }
    const bool ior = axis.kind == AxisKind::Ior;
    if (ior) {
        axis.lower = 1;
        axis.upper = 2.5;
    }
    if (const Json* const range = optional(json, "range")) {
        const bool own = axis.kind == AxisKind::Parameter;
        const double least = own   ? axis.lower
                             : ior ? 0.01
                                   : 0,
                     most = own   ? axis.upper
                            : ior ? 100
                                  : 1;
        const Place here = at.member("range");
        const std::string expected = fmt::format("two growing numbers in [{}, {}]", least, most);
        if (!range->is_array() || range->size() != 2)
            here.fail(*range, expected);
        axis.lower = parse_number((*range)[0], here.element(0), least, most);
        axis.upper = parse_number((*range)[1], here.element(1), least, most);
        if (!(axis.lower < axis.upper))
            here.fail("does not grow; expected " + expected);
    }
    return axis;
}

/// The parameters that no axis sets.
void parse_parameters(const Json& json, const Place& at, TableSpec& spec) {
    check_object(json, at, "an object of numbers");
    for (const auto& [key, value] : json.items()) {
        const Place here = at.member(key);
        if (!value.is_number())
            here.fail(value, "a number");
        try {
            set_parameter(spec, key, value.get<double>());
        } catch (const UsageError& error) {
            here.fail(error.what());
        }
    }
}

/// Throws where the axes do not go together, or with the rest.
void check_axes(const Json& json, const Place& top, const TableSpec& spec) {
    const Place at = top.member("axes");
    std::set<AxisKind> kinds;
    std::set<std::string> names;
    for (const Axis& axis : spec.axes) {
        kinds.insert(axis.kind);
        if (!names.insert(axis.name()).second)
            at.fail(fmt::format("{} is given twice; expected once", axis.name()));
        if (spec.parameters.count(axis.parameter) > 0)
            top.member("parameters")
                .member(axis.parameter)
                .fail(fmt::format("stands beside the axis {}", axis.name()));
    }
    if (kinds.count(AxisKind::Roughness) == 0)
        at.fail("have no roughness; expected an axis roughness");
    const std::size_t fresnel = kinds.count(AxisKind::F0) + kinds.count(AxisKind::Ior);
    if (fresnel > 1)
        at.fail("have f0 and ior; expected one of them");
    if (fresnel > 0 && spec.values() == 2)
        at.fail("have f0 or ior; expected them with the quantities albedo and complement only");
    if (json.contains("f0") && (fresnel > 0 || spec.values() == 2))
        top.member("f0").fail("stands beside a quantity or an axis that says f0 already");
}

TableSpec spec_from(const Json& json, const std::string& source) {
    const Place top{source, ""};
    check_object(json, top, "an object that describes a table");
    check_keys(json, top,
               {"name", "model", "parameters", "f0", "quantity", "encoding", "tolerance", "axes"});
    TableSpec spec;
    const Json* const name = optional(json, "name");
    const std::string identifier = "letters, digits and _, a name for an array in C";
    spec.name =
        name != nullptr ? parse_text(*name, top.member("name"), identifier) : "albedo_table";
    if (!is_identifier(spec.name))
        top.member("name").fail(*name, identifier);
    spec.description = "as specified";
    const Json* const model = optional(json, "model");
    const std::string model_expected = "the name of a model, see brdfit models";
    const Model* const found = find_model(
        model != nullptr ? parse_text(*model, top.member("model"), model_expected) : "ggx");
    if (found == nullptr)
        top.member("model").fail(*model, model_expected);
    try {
        set_model(spec, *found);
    } catch (const UsageError& error) {
        top.member("model").fail(error.what());
    }
    if (const Json* const parameters = optional(json, "parameters"))
        parse_parameters(*parameters, top.member("parameters"), spec);
    if (const Json* const value = optional(json, "f0"))
        spec.f0 = parse_number(*value, top.member("f0"), 0, 1);
    if (const Json* const value = optional(json, "quantity"))
        spec.quantity =
            parse_choice<Quantity>(*value, top.member("quantity"),
                                   {{"albedo", Quantity::Albedo},
                                    {"complement", Quantity::Complement},
                                    {"scale-bias", Quantity::ScaleBias},
                                    {"multiple-scattering", Quantity::MultipleScattering}});
    if (const Json* const value = optional(json, "encoding"))
        spec.encoding = parse_choice<Encoding>(
            *value, top.member("encoding"),
            {{"float", Encoding::Float}, {"half", Encoding::Half}, {"unorm16", Encoding::Unorm16}});
    if (const Json* const value = optional(json, "tolerance"))
        spec.tolerance = parse_number(*value, top.member("tolerance"), least_tolerance, 1);
    const std::string axes_expected =
        fmt::format("an array of 1 to {} axes, fastest first", most_axes);
    const Json& axes = required(json, top, "axes", axes_expected);
    const Place axes_place = top.member("axes");
    if (!axes.is_array() || axes.empty() || axes.size() > most_axes)
        axes_place.fail(axes, axes_expected);
    for (std::size_t i = 0; i < axes.size(); ++i)
        spec.axes.push_back(parse_axis(axes[i], axes_place.element(i), *spec.model));
    check_axes(json, top, spec);
    if (spec.entries() > most_entries)
        axes_place.fail(fmt::format("have {} entries together; expected at most {}", spec.entries(),
                                    most_entries));
    spec.channels = spec.quantity == Quantity::Albedo       ? std::vector<std::string>{"E"}
                    : spec.quantity == Quantity::Complement ? std::vector<std::string>{"complement"}
                    : spec.quantity == Quantity::ScaleBias
                        ? std::vector<std::string>{"scale", "bias"}
                        : std::vector<std::string>{"x", "y"};
    return spec;
}

} // namespace

TableSpec parse_table_spec(const std::string& text, const std::string& source) {
    return spec_from(parse_json(text, source, expected_file), source);
}

TableSpec read_table_spec(const std::string& path) {
    return spec_from(read_json(path, expected_file, most_bytes), path);
}

} // namespace brdfit

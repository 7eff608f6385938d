#include "host/table/table.hpp"

#include "host/error.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <set>

namespace brdfit {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t largest_size = 4096, most_entries = std::size_t{1} << 22;
constexpr int deepest = 8;

/// Reads one object of the specification and refuses what it is not asked for.
class Object {
  public:
    Object(const Json& json, std::string path) : json_(json), path_(std::move(path)) {
        if (!json.is_object())
            throw InputError(path_ + ": expected an object");
    }

    bool has(const std::string& key) {
        known_.insert(key);
        return json_.contains(key);
    }
    const Json& at(const std::string& key) {
        if (!has(key))
            throw InputError(fmt::format("{}.{}: is missing", path_, key));
        return json_.at(key);
    }
    std::string text(const std::string& key) {
        if (!at(key).is_string())
            fail(key, "expected a text");
        return at(key).get<std::string>();
    }
    double number(const std::string& key, double lower, double upper) {
        const double value = at(key).is_number() ? at(key).get<double>() : std::nan("");
        if (!(value >= lower && value <= upper))
            fail(key, fmt::format("expected a number in [{}, {}]", lower, upper));
        return value;
    }
    /// The value that the text of `key` stands for.
    template <typename Value>
    Value choice(const std::string& key, const std::vector<std::pair<const char*, Value>>& known) {
        const std::string name = text(key);
        std::string names;
        for (const auto& [known_name, value] : known) {
            if (name == known_name)
                return value;
            names += (names.empty() ? "" : ", ") + std::string(known_name);
        }
        fail(key, "expected one of " + names);
    }
    [[noreturn]] void fail(const std::string& key, const std::string& expected) const {
        std::string value = json_.at(key).dump(-1, ' ', false, Json::error_handler_t::replace);
        if (value.size() > 60)
            value = value.substr(0, 60) + "...";
        throw InputError(fmt::format("{}.{}: is {}; {}", path_, key, value, expected));
    }
    /// Throws for keys nobody asked for.
    void finish() const {
        for (const auto& [key, value] : json_.items())
            if (known_.count(key) == 0)
                throw InputError(fmt::format("{}: '{}' is an unknown key; expected {}", path_,
                                             key.substr(0, 60), fmt::join(known_, ", ")));
    }
    const std::string& path() const { return path_; }

  private:
    const Json& json_;
    std::string path_;
    std::set<std::string> known_;
};

Axis parse_axis(const Json& json, const std::string& path) {
    Object object(json, path);
    Axis axis;
    axis.kind = object.choice<AxisKind>("axis", {{"cos_theta", AxisKind::CosTheta},
                                                 {"roughness", AxisKind::Roughness},
                                                 {"f0", AxisKind::F0},
                                                 {"ior", AxisKind::Ior}});
    const double size = object.number("size", 2, largest_size);
    if (size != std::floor(size))
        object.fail("size", "expected a whole number");
    axis.size = static_cast<std::size_t>(size);
    if (object.has("nodes"))
        axis.nodes = object.choice<Nodes>("nodes", {{"corners", Nodes::Corners},
                                                    {"centres", Nodes::Centres},
                                                    {"descending", Nodes::Descending}});
    if (object.has("power"))
        axis.power = object.number("power", 0.1, 10);
    if (object.has("least"))
        axis.least = object.number("least", 0, 1);
    if (axis.kind == AxisKind::Ior && object.has("mapping")) {
        axis.reciprocal = object.choice<bool>("mapping", {{"power", false}, {"openpbr", true}});
        if (axis.reciprocal && axis.size % 2 != 0)
            object.fail("size", "expected an even number for the mapping openpbr");
    }
    if (axis.kind == AxisKind::Ior) {
        axis.lower = 1;
        axis.upper = 2.5;
    }
    if (object.has("range")) {
        const Json& range = object.at("range");
        const double most = axis.kind == AxisKind::Ior ? 100 : 1;
        const double least = axis.kind == AxisKind::Ior ? 0.01 : 0;
        if (!range.is_array() || range.size() != 2 || !range[0].is_number() ||
            !range[1].is_number() || !(range[0].get<double>() >= least) ||
            !(range[0].get<double>() < range[1].get<double>()) || !(range[1].get<double>() <= most))
            object.fail("range",
                        fmt::format("expected two growing numbers in [{}, {}]", least, most));
        axis.lower = range[0].get<double>();
        axis.upper = range[1].get<double>();
    }
    object.finish();
    return axis;
}

Json parse_json(const std::string& text, const std::string& source) {
    std::vector<std::set<std::string>> keys;
    const auto guard = [&](int depth, Json::parse_event_t event, const Json& parsed) {
        if (event == Json::parse_event_t::object_start) {
            if (depth > deepest)
                throw InputError(source + ": is nested too deeply");
            keys.emplace_back();
        } else if (event == Json::parse_event_t::array_start && depth > deepest) {
            throw InputError(source + ": is nested too deeply");
        } else if (event == Json::parse_event_t::object_end) {
            keys.pop_back();
        } else if (event == Json::parse_event_t::key &&
                   !keys.back().insert(parsed.get<std::string>()).second) {
            throw InputError(fmt::format("{}: '{}' is given twice", source,
                                         parsed.get<std::string>().substr(0, 60)));
        }
        return true;
    };
    try {
        return Json::parse(text, guard);
    } catch (const Json::exception& error) {
        throw InputError(
            fmt::format("{}: is no JSON: {}", source, std::string(error.what()).substr(0, 200)));
    }
}

} // namespace

TableSpec parse_table_spec(const std::string& text, const std::string& source) {
    const Json json = parse_json(text, source);
    Object object(json, source);
    TableSpec spec;
    spec.name = object.has("name") ? object.text("name") : "albedo_table";
    const bool identifier = !spec.name.empty() && spec.name.size() <= 100 &&
                            std::isdigit(static_cast<unsigned char>(spec.name[0])) == 0 &&
                            std::all_of(spec.name.begin(), spec.name.end(), [](unsigned char c) {
                                return std::isalnum(c) != 0 || c == '_';
                            });
    if (!identifier)
        object.fail("name", "expected letters, digits and _, a name for an array in C");
    spec.description = "as specified";
    const std::string model = object.has("model") ? object.text("model") : "ggx";
    const Model* const found = find_model(model);
    if (found == nullptr)
        object.fail("model", "expected the name of a model, see brdfit models");
    try {
        set_model(spec, *found);
        if (object.has("parameters")) {
            if (!object.at("parameters").is_object())
                object.fail("parameters", "expected an object of numbers");
            for (const auto& [key, value] : object.at("parameters").items()) {
                if (!value.is_number())
                    object.fail("parameters", "expected an object of numbers");
                set_parameter(spec, fmt::format("{}={}", key, value.get<double>()));
            }
        }
    } catch (const UsageError& error) {
        throw InputError(fmt::format("{}: {}", source, error.what()));
    }
    if (object.has("f0"))
        spec.f0 = object.number("f0", 0, 1);
    if (object.has("quantity"))
        spec.quantity = object.choice<Quantity>(
            "quantity", {{"albedo", Quantity::Albedo},
                         {"complement", Quantity::Complement},
                         {"scale-bias", Quantity::ScaleBias},
                         {"multiple-scattering", Quantity::MultipleScattering}});
    if (object.has("encoding"))
        spec.encoding = object.choice<Encoding>(
            "encoding",
            {{"float", Encoding::Float}, {"half", Encoding::Half}, {"unorm16", Encoding::Unorm16}});
    if (object.has("tolerance"))
        spec.tolerance = object.number("tolerance", -1e300, 1e300); // compute_table says more
    const Json& axes = object.at("axes");
    if (!axes.is_array() || axes.empty() || axes.size() > 3)
        object.fail("axes", "expected an array of 1 to 3 axes, fastest first");
    for (std::size_t i = 0; i < axes.size(); ++i)
        spec.axes.push_back(parse_axis(axes[i], fmt::format("{}: axes[{}]", source, i)));
    std::set<AxisKind> kinds;
    for (const Axis& axis : spec.axes)
        if (!kinds.insert(axis.kind).second)
            throw InputError(
                fmt::format("{}.axes: {} is given twice; expected once", source, axis.name()));
    if (kinds.count(AxisKind::Roughness) == 0)
        throw InputError(source + ".axes: expected an axis roughness");
    const bool fresnel = kinds.count(AxisKind::F0) + kinds.count(AxisKind::Ior) > 0;
    if (kinds.count(AxisKind::F0) + kinds.count(AxisKind::Ior) > 1)
        throw InputError(source + ".axes: expected f0 or ior, not both");
    if (fresnel && spec.values() == 2)
        throw InputError(source + ".axes: f0 and ior go with the quantities albedo and complement");
    if (json.contains("f0") && (fresnel || spec.values() == 2))
        throw InputError(source + ".f0: the quantity or an axis says f0 already");
    if (spec.entries() > most_entries)
        throw InputError(fmt::format("{}.axes: {} entries; expected at most {}", source,
                                     spec.entries(), most_entries));
    spec.channels = spec.quantity == Quantity::Albedo       ? std::vector<std::string>{"E"}
                    : spec.quantity == Quantity::Complement ? std::vector<std::string>{"complement"}
                    : spec.quantity == Quantity::ScaleBias
                        ? std::vector<std::string>{"scale", "bias"}
                        : std::vector<std::string>{"x", "y"};
    object.finish();
    return spec;
}

} // namespace brdfit

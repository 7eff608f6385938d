#include "host/model/material.hpp"

#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <set>

namespace brdfit {

namespace {

constexpr std::size_t max_bytes = std::size_t{16} << 20;

/// kd or ks: a strength for each channel. Kernels hold it as float32.
std::vector<double> parse_strengths(const Json& object, const Place& at, const std::string& key,
                                    std::size_t channels) {
    const std::string expected =
        channels == 1 ? "an array of 1 number, for the channel"
                      : fmt::format("an array of {} numbers, one a channel", channels);
    const Json& values = required(object, at, key, expected);
    const Place here = at.member(key);
    if (!values.is_array())
        here.fail(values, expected);
    if (values.size() != channels)
        here.fail(fmt::format("has {} values; expected {}", values.size(), expected));
    std::vector<double> strengths;
    strengths.reserve(channels);
    for (std::size_t i = 0; i < channels; ++i)
        strengths.push_back(
            parse_number(values[i], here.element(i), 0, std::numeric_limits<float>::max()));
    return strengths;
}

/// The model an object names, when its kind is `lobe` (a lobe) or not (a diffuse shape).
const Model& parse_model(const Json& object, const Place& at, bool lobe) {
    std::vector<std::string> known;
    for (const auto* models : {&catalogue(), &table_models()})
        for (const Model& model : *models)
            if ((model.kind == Kind::Lobe) == lobe)
                known.push_back(lobe ? model.name : diffuse_name_of(model));
    const std::string expected =
        fmt::format("a {} model: {}", lobe ? "lobe" : "diffuse", fmt::join(known, ", "));
    const Json& name = required(object, at, "model", expected);
    if (!name.is_string() || std::find(known.begin(), known.end(), name) == known.end())
        at.member("model").fail(name, expected);
    const std::string text = name.get<std::string>();
    return lobe ? *find_model(text) : *find_diffuse(text);
}

std::vector<std::string> names(const std::vector<Parameter>& parameters) {
    std::vector<std::string> list;
    for (const Parameter& parameter : parameters)
        list.push_back(parameter.name);
    return list;
}

/// What `list` has and `other` has not, in order.
std::vector<std::string> without(const std::vector<std::string>& list,
                                 const std::vector<std::string>& other) {
    std::vector<std::string> rest;
    for (const std::string& name : list)
        if (std::find(other.begin(), other.end(), name) == other.end())
            rest.push_back(name);
    return rest;
}

/// Whether the lobe gives its parameters in the isotropic form. Both forms at once are an error.
bool parse_form(const Json& object, const Place& at, const Model& model) {
    const std::vector<std::string> isotropic = names(model.isotropic);
    const std::vector<std::string> anisotropic = names(model.anisotropic);
    const std::vector<std::string> one = without(isotropic, anisotropic);
    const std::vector<std::string> two = without(anisotropic, isotropic);
    const auto given = [&](const std::vector<std::string>& list) {
        return std::find_if(list.begin(), list.end(),
                            [&](const std::string& name) { return object.contains(name); });
    };
    const auto first = given(one), second = given(two);
    const std::string expected =
        fmt::format("either {} or {}", fmt::join(one, ", "), fmt::join(two, " and "));
    if (first != one.end() && second != two.end())
        at.member(*second).fail(fmt::format("stands beside {}; expected {}", *first, expected));
    if (!one.empty() && first == one.end() && second == two.end())
        at.member(one.front()).fail("is missing; expected " + expected);
    return second == two.end();
}

bool optional_bool(const Json& object, const Place& at, const std::string& key) {
    const Json* const found = optional(object, key);
    return found != nullptr && parse_bool(*found, at.member(key));
}

/// The table a lobe names, relative to the material's file.
void parse_table(const Json& object, const Place& at, Lobe& lobe) {
    const std::string expected = "the name of a table that brdfit generate made";
    const Json& name = required(object, at, "table", expected);
    if (!name.is_string() || name.get<std::string>().empty())
        at.member("table").fail(name, expected);
    lobe.table_file = name.get<std::string>();
    lobe.correlated = optional_bool(object, at, "correlated");
    const std::filesystem::path folder = std::filesystem::path(at.source).parent_path();
    try {
        lobe.table = read_table((folder / lobe.table_file).string());
    } catch (const InputError& error) {
        at.member("table").fail(error.what());
    }
    if (lobe.model->name == "microfacet-lambertian" && lobe.table->facets.rows == 0)
        at.member("table").fail(name, "a table with Lambertian facets (brdfit generate "
                                      "--lambertian)");
}

/// The model whose lobe gives an orientation.
const Model& parse_oriented(const Place& at, const Model& model, bool isotropic) {
    const Model* const turned = oriented(model);
    if (turned == nullptr)
        at.member("orientation").fail(fmt::format("a {} lobe has none", model.name));
    if (isotropic)
        at.member("orientation")
            .fail(fmt::format(
                "stands beside {}; expected it beside {}",
                fmt::join(without(names(model.isotropic), names(model.anisotropic)), ", "),
                fmt::join(without(names(model.anisotropic), names(model.isotropic)), " and ")));
    return *turned;
}

Lobe parse_lobe(const Json& object, const Place& at, std::size_t channels) {
    check_object(object, at, "an object that describes a lobe");
    Lobe lobe;
    lobe.model = &parse_model(object, at, true);
    std::vector<std::string> keys = {"model", "ks"};
    for (const auto* parameters : {&lobe.model->isotropic, &lobe.model->anisotropic})
        for (const std::string& name : without(names(*parameters), keys))
            keys.push_back(name);
    keys.push_back("orientation");
    if (lobe.model->table)
        keys.insert(keys.end(), {"table", "correlated"});
    check_keys(object, at, keys);
    lobe.ks = parse_strengths(object, at, "ks", channels);
    lobe.isotropic = parse_form(object, at, *lobe.model);
    if (object.contains("orientation"))
        lobe.model = &parse_oriented(at, *lobe.model, lobe.isotropic);
    for (const Parameter& p : lobe.model->parameters(lobe.isotropic)) {
        const Json& value = required(object, at, p.name,
                                     fmt::format("a number in [{:.6g}, {:.6g}]", p.lower, p.upper));
        lobe.theta.push_back(parse_number(value, at.member(p.name), p.lower, p.upper));
    }
    if (lobe.model->table)
        parse_table(object, at, lobe);
    return lobe;
}

std::vector<std::string> parse_channels(const Json& material, const Place& at) {
    const std::string expected = "an array of channel names";
    const Json& values = required(material, at, "channels", expected);
    const Place here = at.member("channels");
    if (!values.is_array())
        here.fail(values, expected);
    if (values.empty() || values.size() > max_channels)
        here.fail(fmt::format("has {} names; expected 1 to {}", values.size(), max_channels));
    std::vector<std::string> channels;
    std::set<std::string> seen;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::string name = values[i].is_string() ? values[i].get<std::string>() : "";
        if (!is_channel_name(name))
            here.element(i).fail(values[i], channel_name_expected);
        if (!seen.insert(name).second)
            here.element(i).fail(values[i], "a name no other channel has");
        channels.push_back(name);
    }
    return channels;
}

/// For each parameter of the anisotropic form, the index of the one it comes from in the isotropic
/// form: where the names part, one roughness stands for two.
std::vector<std::size_t> isotropic_index(const Model& model) {
    std::vector<std::size_t> index;
    std::size_t i = 0;
    for (const Parameter& parameter : model.anisotropic) {
        if (parameter.scale == Scale::Angle) // turns what may be isotropic
            continue;
        const bool second = !index.empty() && index.back() == i;
        index.push_back(i);
        if (second || parameter.name == model.isotropic[i].name)
            ++i;
    }
    return index;
}

} // namespace

std::vector<double> Lobe::anisotropic_theta() const {
    if (!isotropic)
        return theta;
    std::vector<double> both;
    for (std::size_t i : isotropic_index(*model))
        both.push_back(theta[i]);
    return both;
}

bool Material::isotropic() const {
    return std::all_of(lobes.begin(), lobes.end(), [](const Lobe& lobe) {
        if (lobe.table != nullptr && !lobe.table->isotropic())
            return false;
        const std::vector<double> theta = lobe.anisotropic_theta();
        const std::vector<std::size_t> index = isotropic_index(*lobe.model);
        for (std::size_t a = 1; a < index.size(); ++a)
            if (index[a] == index[a - 1] && theta[a] != theta[a - 1])
                return false;
        return true;
    });
}

namespace {

Material material_from(const Json& json, const std::string& source) {
    const Place top{source, ""};
    check_object(json, top, "an object that describes a material");
    const std::string format = "1, the version of the material format";
    if (const Json& number = required(json, top, "brdfit", format); number != 1)
        top.member("brdfit").fail(number, format);
    check_keys(json, top, {"brdfit", "channels", "diffuse", "lobes", "fit"});

    Material material;
    material.channels = parse_channels(json, top);
    const std::size_t channels = material.channels.size();

    const std::string diffuse_expected = "an object with model and kd (0 where nothing is diffuse)";
    const Json& diffuse = required(json, top, "diffuse", diffuse_expected);
    const Place diffuse_place = top.member("diffuse");
    check_object(diffuse, diffuse_place, diffuse_expected);
    material.diffuse = &parse_model(diffuse, diffuse_place, false);
    std::vector<std::string> diffuse_keys = {"model", "kd"};
    if (material.diffuse->table) {
        diffuse_keys.emplace_back("metal");
        material.metal = optional_bool(diffuse, diffuse_place, "metal");
    }
    check_keys(diffuse, diffuse_place, diffuse_keys);
    material.kd = parse_strengths(diffuse, diffuse_place, "kd", channels);

    const std::string lobes_expected = fmt::format("an array of 0 to {} lobes", max_lobes);
    const Json& lobes = required(json, top, "lobes", lobes_expected);
    const Place lobes_place = top.member("lobes");
    if (!lobes.is_array())
        lobes_place.fail(lobes, lobes_expected);
    if (lobes.size() > max_lobes)
        lobes_place.fail(fmt::format("has {} lobes; expected at most {}", lobes.size(), max_lobes));
    for (std::size_t i = 0; i < lobes.size(); ++i)
        material.lobes.push_back(parse_lobe(lobes[i], lobes_place.element(i), channels));

    if (const std::string& lobe = material.diffuse->lobe;
        !lobe.empty() && (material.lobes.empty() || material.lobes[0].model->name != lobe))
        diffuse_place.member("model").fail(
            diffuse["model"],
            fmt::format("a diffuse model that goes with {}; this one needs a first lobe of {}",
                        material.lobes.empty() ? "no lobe" : material.lobes[0].model->name, lobe));

    if (const Json* const fit = optional(json, "fit")) {
        check_object(*fit, top.member("fit"), "an object");
        material.fit = *fit;
    }
    return material;
}

} // namespace

Material parse_material(const std::string& text, const std::string& source) {
    return material_from(parse_json(text, source, "a material"), source);
}

Material read_material(const std::string& path) {
    return material_from(read_json(path, "a material file", max_bytes), path);
}

nlohmann::ordered_json to_json(const Material& material) {
    Json json;
    json["brdfit"] = 1;
    json["channels"] = material.channels;
    json["diffuse"] = {{"model", diffuse_name_of(*material.diffuse)}, {"kd", material.kd}};
    if (material.diffuse->table)
        json["diffuse"]["metal"] = material.metal;
    json["lobes"] = Json::array();
    for (const Lobe& lobe : material.lobes) {
        Json entry = {{"model", lobe.model->name}, {"ks", lobe.ks}};
        const std::vector<Parameter>& parameters = lobe.model->parameters(lobe.isotropic);
        for (std::size_t i = 0; i < parameters.size(); ++i)
            entry[parameters[i].name] = lobe.theta[i];
        if (lobe.model->table) {
            entry["table"] = lobe.table_file;
            entry["correlated"] = lobe.correlated;
        }
        json["lobes"].push_back(std::move(entry));
    }
    if (!material.fit.is_null())
        json["fit"] = material.fit;
    return json;
}

void write_material(const Material& material, const std::string& path) {
    OutputFile file(path);
    file.write(pretty(to_json(material)) + "\n");
    file.commit();
}

} // namespace brdfit

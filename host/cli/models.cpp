#include "host/cli/command.hpp"
#include "host/model/catalogue.hpp"

#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace brdfit::cli {

namespace {

using Json = nlohmann::ordered_json;

const char* scale_name(Scale scale) {
    switch (scale) {
    case Scale::Log:
        return "log";
    case Scale::Log1p:
        return "log1p";
    case Scale::AboutOne:
        return "about-one";
    case Scale::Angle:
        return "angle";
    case Scale::Linear:
        break;
    }
    return "linear";
}

Json to_json(const std::vector<Parameter>& parameters) {
    Json list = Json::array();
    for (const Parameter& p : parameters)
        list.push_back({{"name", p.name},
                        {"lower", p.lower},
                        {"upper", p.upper},
                        {"default", p.start},
                        {"scale", scale_name(p.scale)}});
    return list;
}

Json to_json(const Model& model) {
    Json json = {{"name", model.name}, {"kind", model.kind == Kind::Lobe ? "lobe" : "diffuse"}};
    if (!model.lobe.empty())
        json["lobe"] = model.lobe;
    if (!model.diffuse_name.empty())
        json["diffuse"] = model.diffuse_name;
    json["shape"] = model.shape;
    json["equation"] = model.equation;
    json["reciprocal"] = model.reciprocal;
    json["conserves_energy"] = model.conserves_energy;
    const Model& of = model.lobe.empty() ? model : model_named(model.lobe);
    json["table"] = model.table;
    json["isotropic"] = to_json(of.isotropic);
    json["anisotropic"] = to_json(of.anisotropic);
    const Model* const turned = oriented(of);
    json["orientation"] =
        turned != nullptr ? to_json({turned->anisotropic.back()})[0] : Json(nullptr);
    return json;
}

bool lists(const std::vector<Parameter>& parameters, const std::string& name) {
    for (const Parameter& p : parameters)
        if (p.name == name)
            return true;
    return false;
}

void print(const Parameter& p, const char* note) {
    fmt::print("  {:<8} [{:g}, {:g}], default {:g}{}\n", p.name, p.lower, p.upper, p.start, note);
}

/// One model as a block: what it is, its formula, its source, then a line for each parameter.
void print(const Model& model) {
    fmt::print("{:<20} {}, {}reciprocal, {}\n", model.name,
               model.kind == Kind::Lobe ? "lobe" : "diffuse", model.reciprocal ? "" : "not ",
               model.conserves_energy ? "conserves energy" : "may exceed an albedo of 1");
    fmt::print("  {}\n  {}\n", model.shape, model.equation);
    if (model.table)
        fmt::print("  with a table that brdfit generate makes; not fitted by brdfit fit\n");
    for (const auto* models : {&catalogue(), &table_models()})
        for (const Model& other : *models)
            if (!other.diffuse_name.empty() && other.lobe == model.name)
                fmt::print("  with {} {}: {} ({})\n",
                           other.table ? "the diffuse model" : "--diffuse", other.diffuse_name,
                           other.shape, other.equation);
    // A coupled diffuse shape comes with the parameters of its lobe.
    const Model& of = model.lobe.empty() ? model : model_named(model.lobe);
    for (const Parameter& p : of.isotropic)
        print(p, lists(of.anisotropic, p.name) ? "" : ", isotropic form");
    for (const Parameter& p : of.anisotropic)
        if (!lists(of.isotropic, p.name))
            print(p, ", anisotropic form");
    if (const Model* const turned = oriented(of))
        print(turned->anisotropic.back(),
              ", degrees about the normal, with the anisotropic form (--orient)");
}

} // namespace

void add_models(CLI::App& app, const Globals&, Action& action) {
    struct Options {
        std::string name;
        bool json = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "models", "List the models: parameters, bounds, defaults, equation, paper");
    command->add_option("NAME", options->name, "only this model");
    command->add_flag("--json", options->json,
                      "print JSON: an array with an object for each model");
    command->footer(
        "iz, oz, hz: cosines of light, viewer and half vector h with the normal; c = wi.h = wo.h.\n"
        "F = f0 + (1-f0)(1-c)^5; D: Beckmann's distribution of h.\n"
        "Example:\n  brdfit models kurt");
    command->callback([options, &action] {
        action = [options] {
            std::vector<Model> chosen;
            for (const auto* models : {&catalogue(), &table_models()})
                for (const Model& model : *models)
                    if (options->name.empty() ? model.listed()
                                              : &model == &model_named(options->name))
                        chosen.push_back(model);
            if (options->json) {
                Json json = Json::array();
                for (const Model& model : chosen)
                    json.push_back(to_json(model));
                fmt::print("{}\n", json.dump(2));
                return 0;
            }
            for (std::size_t i = 0; i < chosen.size(); ++i) {
                fmt::print("{}", i == 0 ? "" : "\n");
                print(chosen[i]);
            }
            return 0;
        };
    });
}

} // namespace brdfit::cli

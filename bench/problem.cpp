#include "bench/problem.hpp"

#include "bench/native/scalar.hpp"
#include "host/error.hpp"
#include "host/evaluate/synthesise.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace brdfit::bench {

namespace {

constexpr double noise = 0.02;
constexpr std::uint64_t seed = 1;
constexpr double roughness = 0.25;
constexpr const char* source = "the benchmark's material";
constexpr const char* material_text = R"({"brdfit": 1, "channels": ["R", "G", "B"],
    "diffuse": {"model": "lambert", "kd": [0.2, 0.1, 0.05]},
    "lobes": [{"model": "kurt", "ks": [0.3, 0.4, 0.5], "f0": 0.2, "m": 0.2, "alpha": 0.2}]})";

// One value for every kind of parameter: alike roughnesses, 0.3 of a linear range.
double typical(const Parameter& p) {
    switch (p.scale) {
    case Scale::Log:
        return std::clamp(roughness, p.lower, p.upper);
    case Scale::Log1p:
        return std::clamp(2 / (roughness * roughness), p.lower, p.upper);
    case Scale::Linear:
    case Scale::AboutOne:
    case Scale::Angle:
        break;
    }
    return p.lower + 0.3 * (p.upper - p.lower);
}

Structure structure_of(const Model& model) {
    Structure structure;
    structure.diffuse = model.kind == Kind::Lobe ? &model_named("lambert") : &model;
    if (model.kind == Kind::Lobe)
        structure.lobes = {&model};
    if (model.kind == Kind::DiffuseAndLobe)
        structure.lobes = {&model_named(model.lobe)};
    return structure;
}

} // namespace

Material Problem::material() const {
    Material material = parse_material(material_text, source);
    material.diffuse = structure.diffuse;
    material.lobes.resize(structure.lobes.size());
    if (!material.lobes.empty()) {
        material.lobes[0].model = structure.lobes[0];
        material.lobes[0].theta = theta;
    }
    return material;
}

std::vector<Problem> problems(const std::vector<std::string>& names) {
    std::vector<Problem> all;
    std::string known;
    for (const Model& model : catalogue()) {
        Problem problem{structure_of(model), {}};
        if (!model.listed() || !ScalarModel::find(problem.structure))
            continue;
        known += (known.empty() ? "" : ", ") + model.name;
        if (!names.empty() && std::find(names.begin(), names.end(), model.name) == names.end())
            continue;
        for (const Parameter& p : layout_of(problem.structure).parameters)
            problem.theta.push_back(typical(p));
        all.push_back(std::move(problem));
    }
    for (const std::string& name : names)
        if (std::none_of(all.begin(), all.end(),
                         [&](const Problem& p) { return p.name() == name; }))
            throw UsageError(fmt::format("-m {}: not measured; known: {}", name, known));
    return all;
}

std::vector<std::vector<double>> candidates_of(const Problem& problem, std::size_t count) {
    const std::vector<Parameter> parameters = layout_of(problem.structure).parameters;
    std::vector<std::vector<double>> candidates(count, problem.theta);
    for (std::size_t n = 0; n < count; ++n)
        for (std::size_t p = 0; p < parameters.size(); ++p) {
            // From half to twice the value, in ever different mixtures.
            const double place = static_cast<double>((n * (p + 1)) % count) /
                                 static_cast<double>(std::max<std::size_t>(count - 1, 1));
            candidates[n][p] = std::clamp(problem.theta[p] * (0.5 + 1.5 * place),
                                          parameters[p].lower, parameters[p].upper);
        }
    return candidates;
}

Samples data_of(const Device& device, std::size_t most) {
    Samples samples =
        synthesise_merl(device, parse_material(material_text, source), noise, seed, source);
    samples.source = source;
    const std::size_t valid = samples.valid_count();
    const std::size_t step = most == 0 ? 1 : std::max<std::size_t>(valid / most, 1);
    for (std::size_t k = 0, n = 0; k < samples.count(); ++k)
        if (samples.valid[k] != 0 && n++ % step != 0)
            samples.valid[k] = 0;
    return samples;
}

} // namespace brdfit::bench

#include "fit/structures.hpp"

#include "host/error.hpp"
#include "host/model/material.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace brdfit {

namespace {

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text)
        if (c == separator)
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

} // namespace

Structure structure_named(const std::string& names, int lobes, const std::string& diffuse,
                          bool isotropic) {
    Structure structure;
    structure.isotropic = isotropic;
    structure.diffuse = &model_named("lambert");
    const std::vector<std::string> parts = split(names, '+');
    for (const std::string& part : parts) {
        const Model& model = model_named(part);
        if (model.table)
            throw UsageError(fmt::format("'{}': {} has a table in place of parameters to fit; "
                                         "brdfit generate --from recovers one from measurements",
                                         names, part));
        if (model.kind == Kind::Diffuse) {
            if (parts.size() > 1)
                throw UsageError(fmt::format("'{}': {} is a diffuse shape, which every fit has; "
                                             "choose it with --diffuse",
                                             names, part));
            structure.diffuse = &model;
        } else if (model.kind == Kind::DiffuseAndLobe) {
            // Its lobe comes first: the diffuse shape has that one's F.
            structure.diffuse = &model;
            structure.lobes.insert(structure.lobes.begin(), &model_named(model.lobe));
        } else {
            structure.lobes.push_back(&model);
        }
    }
    if (parts.size() == 1 && !structure.lobes.empty())
        structure.lobes.resize(static_cast<std::size_t>(lobes), structure.lobes.front());
    if (structure.lobes.size() > max_lobes)
        throw UsageError(fmt::format("'{}' has {} lobes; at most {} are possible", names,
                                     structure.lobes.size(), max_lobes));
    if (!diffuse.empty()) {
        const Model* const found = find_diffuse(diffuse);
        if (found == nullptr)
            throw UsageError(fmt::format("--diffuse {}: {}", diffuse,
                                         find_model(diffuse) != nullptr
                                             ? "is a lobe model, no diffuse shape"
                                             : "is unknown"));
        const Model& model = *found;
        if (model.table)
            throw UsageError(
                fmt::format("--diffuse {}: goes with a table; it is not fitted", diffuse));
        if (model.kind == Kind::DiffuseAndLobe &&
            (structure.lobes.empty() || structure.lobes.front()->name != model.lobe))
            throw UsageError(fmt::format("--diffuse {}: the first lobe of '{}' is not {}", diffuse,
                                         names, model.lobe));
        if (structure.coupled() && structure.diffuse != &model)
            throw UsageError(
                fmt::format("--diffuse {}: '{}' brings its own diffuse shape", diffuse, names));
        structure.diffuse = &model;
    }
    return structure;
}

std::vector<Structure> structures_named(const std::vector<std::string>& models,
                                        std::vector<int> lobes, const std::string& diffuse,
                                        bool isotropic) {
    std::vector<std::string> names;
    for (const std::string& name : models) {
        if (name != "all") {
            names.push_back(name);
            continue;
        }
        for (const Model& model : catalogue())
            if (model.listed())
                names.push_back(model.name);
    }
    std::sort(lobes.begin(), lobes.end());
    std::vector<Structure> structures;
    std::set<std::string> known;
    for (const int count : lobes)
        for (const std::string& name : names) {
            // `all` leaves out what the diffuse shape asked for cannot go with.
            const bool from_all = std::find(models.begin(), models.end(), name) == models.end();
            try {
                const Structure structure = structure_named(name, count, diffuse, isotropic);
                if (known.insert(structure.key()).second)
                    structures.push_back(structure);
            } catch (const UsageError&) {
                if (!from_all)
                    throw;
            }
        }
    if (structures.empty())
        throw UsageError("no model goes with the diffuse shape asked for");
    return structures;
}

void check_start(const Material& start, const Structure& structure) {
    bool same = start.diffuse == structure.diffuse && start.lobes.size() == structure.lobes.size();
    for (std::size_t l = 0; same && l < structure.lobes.size(); ++l)
        same = start.lobes[l].model->name == structure.lobes[l]->name; // turned or not
    if (!same)
        throw UsageError(fmt::format("--start: its lobes and diffuse shape are not those of {}",
                                     structure.name()));
}

} // namespace brdfit

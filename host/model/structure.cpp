#include "host/model/structure.hpp"

#include <algorithm>

namespace brdfit {

std::vector<PlacedModel> placed_models(const Structure& structure) {
    std::vector<PlacedModel> placed;
    int planes = 0;
    const auto place = [&](const Model* model) {
        const bool known = std::any_of(placed.begin(), placed.end(),
                                       [&](const PlacedModel& p) { return p.model == model; });
        if (known)
            return;
        placed.push_back({model, planes});
        planes += model->planes(structure.isotropic);
    };
    place(structure.diffuse);
    for (const Model* lobe : structure.lobes)
        place(lobe);
    return placed;
}

std::string Structure::name() const {
    if (lobes.empty())
        return diffuse->name;
    const bool one_model = std::all_of(
        lobes.begin(), lobes.end(), [&](const Model* m) { return m->name == lobes.front()->name; });
    std::string text = coupled() ? diffuse->name : lobes.front()->name;
    for (std::size_t l = 1; l < lobes.size() && !one_model; ++l)
        text += "+" + lobes[l]->name;
    return text;
}

bool Structure::has_tables() const {
    return std::any_of(lobes.begin(), lobes.end(), [](const Model* m) { return m->table; });
}

bool Structure::turns() const {
    return std::any_of(lobes.begin(), lobes.end(), [](const Model* m) { return m->turns; });
}

std::string Structure::key() const {
    std::string text = diffuse->name + (isotropic ? " isotropic" : " anisotropic");
    for (const Model* lobe : lobes)
        text += " " + lobe->name + (lobe->turns ? " turned" : "");
    return text;
}

Structure turned(Structure structure) {
    structure.isotropic = false;
    for (const Model*& lobe : structure.lobes)
        if (const Model* const model = oriented(*lobe))
            lobe = model;
    return structure;
}

StructureLayout layout_of(const Structure& structure) {
    StructureLayout layout;
    layout.basis = 1 + static_cast<int>(structure.lobes.size());
    for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
        layout.lobe_begin.push_back(static_cast<int>(layout.parameters.size()));
        for (const Parameter& parameter : structure.lobes[l]->parameters(structure.isotropic)) {
            layout.entries.push_back(
                {static_cast<int>(l) + 1, static_cast<int>(layout.parameters.size())});
            layout.parameters.push_back(parameter);
        }
    }
    layout.lobe_begin.push_back(static_cast<int>(layout.parameters.size()));
    // A coupled diffuse shape depends on the first lobe's f0.
    if (structure.coupled())
        layout.entries.push_back({0, 0});
    for (const PlacedModel& p : placed_models(structure))
        layout.planes += p.model->planes(structure.isotropic);
    return layout;
}

bool same_planes(const Structure& a, const Structure& b) {
    const std::vector<PlacedModel> of_a = placed_models(a), of_b = placed_models(b);
    return a.isotropic == b.isotropic &&
           std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                      [](const PlacedModel& p, const PlacedModel& q) {
                          return p.model == q.model && p.first_plane == q.first_plane;
                      });
}

std::size_t parameter_stride(const Structure& structure) {
    return structure.has_tables()
               ? 0
               : std::max<std::size_t>(1, layout_of(structure).parameters.size());
}

} // namespace brdfit

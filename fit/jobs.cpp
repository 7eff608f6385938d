#include "fit/jobs.hpp"

#include "fit/structures.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <set>

namespace brdfit {

std::vector<Structure> structures_of(const FitRequest& request, bool isotropic) {
    return structures_named(request.models, request.lobes, request.diffuse, isotropic);
}

void check(const FitRequest& request) {
    for (const bool isotropic : {true, false}) {
        if (request.isotropic && *request.isotropic != isotropic)
            continue;
        const std::vector<Structure> structures = structures_of(request, isotropic);
        for (const Structure& structure : structures)
            Space(structure.lobes, isotropic, request.options.ranges); // throws on contradictions
        for (const ParameterRange& range : request.options.ranges) {
            const auto means_one_of = [&](const Structure& structure) {
                std::vector<const Model*> lobes = structure.lobes;
                const auto lobe = static_cast<std::size_t>(range.lobe);
                if (lobe > 0)
                    lobes = lobe > lobes.size() ? std::vector<const Model*>{}
                                                : std::vector<const Model*>{lobes[lobe - 1]};
                return names_parameter_of(range, lobes);
            };
            if (std::none_of(structures.begin(), structures.end(), means_one_of))
                throw UsageError(
                    range.lobe == 0
                        ? fmt::format("no model asked for has a parameter '{}'", range.name)
                        : fmt::format("no fit asked for has a parameter '{}.{}'", range.lobe,
                                      range.name));
        }
    }
}

std::vector<std::string> distinct_stems(const std::vector<std::string>& files) {
    std::set<std::string> taken;
    std::vector<std::string> stems;
    for (const std::string& file : files) {
        const std::string stem = std::filesystem::path(file).stem().string();
        std::string name = stem;
        for (int i = 2; !taken.insert(name).second; ++i)
            name = fmt::format("{}-{}", stem, i);
        stems.push_back(name);
    }
    return stems;
}

} // namespace brdfit

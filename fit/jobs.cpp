#include "fit/jobs.hpp"

#include "fit/structures.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <numeric>
#include <set>
#include <utility>

namespace brdfit {

Structure formed(const FitRequest& request, Structure structure, bool isotropic) {
    structure.isotropic = isotropic;
    return request.orient && !isotropic ? turned(std::move(structure)) : structure;
}

std::vector<Structure> structures_of(const FitRequest& request, bool isotropic) {
    std::vector<Structure> structures = structures_named(
        request.models, request.lobes.empty() ? std::vector<int>{1} : request.lobes,
        request.diffuse, isotropic);
    for (Structure& structure : structures)
        structure = formed(request, std::move(structure), isotropic);
    return structures;
}

namespace {

// Throws UsageError for a number of lobes asked for that no structure has.
void check_lobes(const FitRequest& request, const std::vector<Structure>& structures) {
    const bool lambert_alone =
        std::all_of(structures.begin(), structures.end(),
                    [](const Structure& structure) { return structure.lobes.empty(); });
    for (const int lobes : request.lobes)
        if (!lambert_alone &&
            std::none_of(structures.begin(), structures.end(), [&](const Structure& structure) {
                return structure.lobes.size() == static_cast<std::size_t>(lobes);
            }))
            throw UsageError(fmt::format("--lobes {}: no model asked for can have {} lobes; a "
                                         "mixture has those it names",
                                         lobes, lobes));
}

// How many letters have to be put in, left out or replaced to make one word of another.
std::size_t edits(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

// The parameters that the structures have, those nearest to `name` first.
// `number`: of one lobe, or 0.
std::string known_names(const std::vector<Structure>& structures, const std::string& name,
                        int number) {
    std::vector<std::string> names;
    for (const Structure& structure : structures)
        for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
            if (number != 0 && l + 1 != static_cast<std::size_t>(number))
                continue;
            for (const Parameter& parameter : structure.lobes[l]->parameters(structure.isotropic))
                if (std::find(names.begin(), names.end(), parameter.name) == names.end())
                    names.push_back(parameter.name);
        }
    std::stable_sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
        return edits(name, a) < edits(name, b);
    });
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

} // namespace

void check(const FitRequest& request) {
    // These know the parameters of both forms.
    const std::vector<Structure> anisotropic = structures_of(request, false);
    if (request.orient && request.isotropic.value_or(false))
        throw UsageError("--orient: contradicts --isotropic; isotropic data has no orientation");
    if (request.orient && std::none_of(anisotropic.begin(), anisotropic.end(),
                                       [](const Structure& s) { return s.turns(); }))
        throw UsageError("--orient: no model asked for has two roughnesses to orient");
    for (const bool isotropic : {true, false}) {
        if (request.isotropic && *request.isotropic != isotropic)
            continue;
        const std::vector<Structure> structures = structures_of(request, isotropic);
        check_lobes(request, structures);
        for (const Structure& structure : structures) {
            if (request.options.start)
                check_start(*request.options.start, structure);
            Space(structure.lobes, isotropic, request.options.ranges); // throws on contradictions
        }
        for (const ParameterRange& range : request.options.ranges) {
            const auto means_one_of = [&](const Structure& structure) {
                std::vector<const Model*> lobes = structure.lobes;
                const auto lobe = static_cast<std::size_t>(range.lobe);
                if (lobe > 0)
                    lobes = lobe > lobes.size() ? std::vector<const Model*>{}
                                                : std::vector<const Model*>{lobes[lobe - 1]};
                return names_parameter_of(range, lobes);
            };
            if (std::none_of(anisotropic.begin(), anisotropic.end(), means_one_of))
                throw UsageError(
                    range.lobe == 0
                        ? fmt::format("no model asked for has a parameter '{}'; they have {}",
                                      range.name, known_names(structures, range.name, 0))
                        : fmt::format(
                              "no fit asked for has a parameter '{0}.{1}'; lobe {0} has {2}",
                              range.lobe, range.name,
                              known_names(structures, range.name, range.lobe)));
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

std::string material_path(const FitRequest& request, const std::string& stem,
                          const Structure& structure) {
    return (std::filesystem::path(request.folder) /
            fmt::format("{}.{}.{}.json", stem, structure.name(), structure.lobes.size()))
        .string();
}

void check_none_is_there(const std::vector<std::string>& paths) {
    std::vector<std::string> there;
    for (const std::string& path : paths) {
        std::error_code unknown;
        if (std::filesystem::is_regular_file(path, unknown))
            there.push_back(path);
    }
    if (!there.empty())
        throw InputError(fmt::format(
            "{}{} there already; --force replaces results, or choose "
            "another folder",
            there.front(),
            there.size() == 1 ? " is" : fmt::format(" and {} more are", there.size() - 1)));
}

void check_nothing_is_replaced(const FitRequest& request, const std::vector<std::string>& also) {
    if (request.force)
        return;
    std::vector<std::string> paths;
    // Names do not depend on the form.
    for (const std::string& stem : distinct_stems(request.files))
        for (const Structure& structure : structures_of(request, request.isotropic.value_or(true)))
            paths.push_back(material_path(request, stem, structure));
    if (!request.csv.empty())
        paths.push_back(request.csv);
    paths.insert(paths.end(), also.begin(), also.end());
    check_none_is_there(paths);
}

} // namespace brdfit

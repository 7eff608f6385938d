#pragma once

#include "fit/fit.hpp"
#include "host/model/structure.hpp"

#include <optional>
#include <string>
#include <vector>

// Requests to fit many files: what they mean, whether they make sense, and how results are named.

namespace brdfit {

/// What to fit to which files.
struct FitRequest {
    std::vector<std::string> files;
    std::vector<std::string> models; ///< names, mixtures `a+b`, or `all`
    std::vector<int> lobes;          ///< numbers of lobes; empty: 1, or what a mixture has
    std::string diffuse;             ///< empty: lambert, or what a coupled model brings
    FitOptions options;
    std::optional<bool> isotropic; ///< overrides what scattered data says
    /// Fits the orientation of each lobe's frame too, where the data is anisotropic.
    bool orient = false;
    std::string folder; ///< for the materials
    std::string csv;    ///< summary; empty: none
    bool force = false; ///< replace files that exist
};

/// A structure in the form that is fitted to isotropic or anisotropic data.
Structure formed(const FitRequest& request, Structure structure, bool isotropic);
/// The structures to fit to isotropic or anisotropic data, each once, fewer lobes first.
std::vector<Structure> structures_of(const FitRequest& request, bool isotropic);

/// Throws UsageError where the request contradicts itself or names what does not exist.
void check(const FitRequest& request);

/// A stem for each file's materials; equal stems get numbers.
std::vector<std::string> distinct_stems(const std::vector<std::string>& files);
/// Where a file's material of a structure goes: FOLDER/STEM.MODEL.LOBES.json.
std::string material_path(const FitRequest& request, const std::string& stem,
                          const Structure& structure);
/// Throws InputError naming those of the paths that are files.
void check_none_is_there(const std::vector<std::string>& paths);
/// Throws InputError naming files that the request, or writing `also`, would replace, unless it
/// may.
void check_nothing_is_replaced(const FitRequest& request,
                               const std::vector<std::string>& also = {});

} // namespace brdfit

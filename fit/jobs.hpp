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
    std::vector<int> lobes{1};
    std::string diffuse; ///< empty: lambert, or what a coupled model brings
    FitOptions options;
    std::optional<bool> isotropic; ///< overrides what scattered data says
    std::string folder;            ///< for the materials
};

/// The structures to fit to isotropic or anisotropic data, each once, fewer lobes first.
std::vector<Structure> structures_of(const FitRequest& request, bool isotropic);

/// Throws UsageError where the request contradicts itself or names what does not exist.
void check(const FitRequest& request);

/// A stem for each file's materials; equal stems get numbers.
std::vector<std::string> distinct_stems(const std::vector<std::string>& files);

} // namespace brdfit

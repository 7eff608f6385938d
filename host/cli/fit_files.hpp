#pragma once

#include "fit/fit.hpp"
#include "host/cli/command.hpp"

#include <optional>
#include <string>
#include <vector>

namespace brdfit::cli {

/// What `brdfit fit` is asked to do.
struct FitRequest {
    std::vector<std::string> files;
    std::vector<std::string> models; ///< names, mixtures `a+b`, or `all`
    std::vector<int> lobes{1};
    std::string diffuse; ///< empty: lambert, or what a coupled model brings
    FitOptions options;
    std::optional<bool> isotropic; ///< overrides what scattered data says
    std::string folder;            ///< for the materials
    std::string csv;               ///< summary; empty: none
    bool json = false;
};

/// Throws UsageError where the request contradicts itself or names what does not exist.
void check(const FitRequest& request);

/// Fits every file, writes the materials, prints a table a file. A file that fails is reported and
/// the others go on. Returns the exit status.
int fit_files(const FitRequest& request, const Globals& globals);

} // namespace brdfit::cli

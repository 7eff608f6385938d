#pragma once

#include "fit/jobs.hpp"
#include "host/cli/command.hpp"

#include <string>

namespace brdfit::cli {

/// Where the results go besides the material files.
struct FitSummaries {
    std::string csv;   ///< file; empty: none
    bool json = false; ///< on stdout, in place of the tables
};

/// Fits every file, writes the materials, prints a table a file. A file that fails is reported and
/// the others go on. Returns the exit status.
int fit_files(const FitRequest& request, const FitSummaries& summaries, const Globals& globals);

} // namespace brdfit::cli

#pragma once

#include "fit/jobs.hpp"
#include "host/cli/command.hpp"

namespace brdfit::cli {

/// Fits every file, writes the materials and the summary, prints a table a file or, for `json`, all
/// results as JSON. A fit that fails is reported, is a row with its reason, and the others go on.
/// Returns the exit status. Throws InputError, before any work, where it would replace a file.
int fit_files(const FitRequest& request, bool json, const Globals& globals);

} // namespace brdfit::cli

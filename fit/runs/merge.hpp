#pragma once

#include "fit/report.hpp"
#include "fit/runs/log.hpp"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace brdfit {

/// Where the results of a run go; what is empty is not written.
struct MergeOutputs {
    std::string database;  ///< SQLite
    std::string csv;       ///< one flat row a fit, the columns of FitCsv
    std::string materials; ///< folder for the material files, as `fit` writes them
    bool best = false;     ///< of these, for each file and metric, the fit of the least error only
};

/// What a merge found.
struct MergeReport {
    std::size_t done = 0, failed = 0, left = 0;
    std::size_t materials = 0;  ///< written
    std::size_t duplicates = 0; ///< rows of tasks that were made before
    std::vector<BrokenLine> broken;
    /// The devices, with driver, form, kernels and version, that made the fits, and how many each.
    std::map<std::string, std::size_t> made_by;
    /// How far errors of tasks that two of these made differ at most, relative.
    double largest_difference = 0;
};

/// Relative difference of the errors of one task, made on two devices, up to which they are one
/// result.
inline constexpr double same_error = 1e-5;

/// Writes the results of a run, finished or not, in the order of its plan. Each file appears whole
/// or not at all. Throws InputError, naming both lines, where two of a task differ in more than
/// their times, or, made on unlike devices, in their error by more than same_error.
///
/// The database has the tables settings (key, value), files (file, path, sha256, bytes), fits (one
/// row a fit, with its material as JSON; state 'done', or 'failed' with the reason) and parameters
/// (fit, lobe: 0 for kd, parameter: m, ks_R, ..., value, standard_error, at_bound).
MergeReport merge_run(const Plan& plan, const std::string& folder, const MergeOutputs& outputs,
                      const ProgressFunction& progress = {});

/// What is done with the fits of a run.
struct RowReaders {
    std::function<void(FitRow, const Task&)> done;
    std::function<void(FailedFit, const Task&)> failed;
};
/// Reads the results of a run, finished or not, in the order of its plan, each task's once. Throws
/// like merge_run.
MergeReport read_rows(const Plan& plan, const std::string& folder, const RowReaders& readers,
                      const ProgressFunction& progress = {});

/// The fit that a logged row is of, its material with its record included. Throws InputError naming
/// `place` where the row holds something else.
FitRow fit_row(const Json& row, const Task& task, const PlannedFile& file,
               const std::string& place);

} // namespace brdfit

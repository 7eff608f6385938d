#pragma once

#include "fit/report.hpp"
#include "host/progress.hpp"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

// What a report tells of: the fits of many files, made by `run` or by `fit`.

namespace brdfit {

/// A file that was fitted to.
struct ReportedMaterial {
    std::string name;   ///< unlike any other's
    std::string path;   ///< as it was given
    std::string file;   ///< where it should be
    std::string sha256; ///< of its bytes when it was fitted to; empty: unknown
};

struct ReportedFit {
    std::size_t material; ///< in Results::materials
    FitResult result;     ///< its material without record
    Metric metric;

    double error() const { return result.errors[static_cast<std::size_t>(metric)]; }
    std::size_t lobes() const { return result.material.lobes.size(); }
    /// "kurt, 2 lobes"
    std::string name() const;
};

struct ReportedFailure {
    std::size_t material; ///< in Results::materials
    std::string model;    ///< empty: the whole file
    std::size_t lobes;
    std::string reason;
};

struct Results {
    std::vector<std::pair<std::string, std::string>> settings; ///< name and value, for people
    std::vector<std::string> notes;                            ///< what is missing or broken
    std::vector<ReportedMaterial> materials;
    std::vector<ReportedFit> fits;
    std::vector<ReportedFailure> failures;
    Metric metric = Metric::Ngan; ///< that all fits minimise
};

/// What to tell of results; empty: all.
struct Selection {
    std::vector<std::string> materials; ///< names, with the shell's * ? [
    std::vector<std::string> models;    ///< as `-m` names them
    std::string metric;                 ///< empty: the first that there are fits of
};

/// The results in a folder that `plan` and `run` wrote, or `fit`: then failures are told by those
/// of its .csv files that `fit --csv` wrote. Throws InputError for a folder with neither and for
/// broken results, UsageError where nothing has a selected name.
Results read_results(const std::string& folder, const Selection& selection,
                     const ProgressFunction& progress = {});

} // namespace brdfit

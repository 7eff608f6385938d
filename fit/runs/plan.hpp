#pragma once

#include "fit/jobs.hpp"
#include "host/files/json.hpp"

#include <cstdint>
#include <string>
#include <vector>

// A plan: the fits that a run is to make, written down before the first is made, so that any number
// of processes can share them and a stopped run goes on.

namespace brdfit {

/// A file to fit to.
struct PlannedFile {
    std::string path;   ///< as it was given
    std::string sha256; ///< of its bytes
    std::uint64_t bytes = 0;
};

/// One fit of the plan.
struct Task {
    /// SHA-256 of what determines its result, in canonical JSON: the file's digest, structure,
    /// metric, options, version of the algorithm. Equal for copies of one file.
    std::string id;
    std::size_t file = 0; ///< in Plan::files
    Structure structure;  ///< its form, isotropic or not, is the file's
    Metric metric = Metric::Ngan;
    std::string output; ///< name of its material file, unlike any other task's

    /// How long it takes, about, compared with others.
    double cost() const;
};

struct Plan {
    FitRequest settings; ///< files, folder, csv and the one metric are unused
    std::vector<Metric> metrics;
    std::string folder; ///< that relative paths of files begin at
    std::vector<PlannedFile> files;
    std::vector<Task> tasks; ///< by file, metric, number of lobes

    /// Where a file is.
    std::string path_of(const PlannedFile& file) const;
    /// What to fit a task with.
    FitOptions options_of(const Task& task) const;
};

/// Plans the fits of a request by each of the metrics. Reads every file for its digest. Throws
/// InputError for a file that cannot be read and a name that is not UTF-8.
Plan make_plan(const FitRequest& request, const std::vector<Metric>& metrics,
               const ProgressFunction& progress = {});

/// The settings as the plan holds them, by the names of the options.
Json settings_json(const Plan& plan);

/// Writes the plan to FOLDER/plan.json, whole or not at all, on the disk when it returns.
void write_plan(const Plan& plan, const std::string& folder);

/// Reads FOLDER/plan.json. Throws InputError for a folder without one, a plan of another version of
/// format or algorithm, and one that is not as write_plan wrote it.
Plan read_plan(const std::string& folder);

inline constexpr std::size_t most_shards = 100000;

/// A part of a plan, `number` of `count`, from 0.
struct Shard {
    std::size_t number = 0, count = 1;
    std::string name() const; ///< "0-of-4"
};

/// The tasks of a shard, as indices, in the order of the plan: whole files where the shards stay
/// about equal in cost. Each task is in one shard; copies of a file are together.
std::vector<std::size_t> tasks_of(const Plan& plan, const Shard& shard);

} // namespace brdfit

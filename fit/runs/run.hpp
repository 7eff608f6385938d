#pragma once

#include "fit/devices.hpp"
#include "fit/runs/log.hpp"

#include <functional>
#include <string>

namespace brdfit {

/// How a shard is run, and what is told of it. The functions are never called by two threads at
/// once, but `stop` and `abandon`, which may be.
struct RunOptions {
    Shard shard;
    // In threads; results are the same whatever they are.
    int jobs = 1;         ///< files fitted to at once, on each device that has files of its own
    int fits_at_once = 0; ///< to one file, on a device; 0: as many as keep the device busy
    bool retry_failed = false;
    std::function<bool()> stop; ///< whether no further task is to be begun
    /// Whether those under way are to be given up too, by any thread; they are left undone.
    std::function<bool()> abandon;
    /// Before the first task: how many are to be made.
    std::function<void(std::size_t tasks)> begin;
    /// A task begins; `done` of those were finished.
    std::function<ProgressFunction(const Task&, std::size_t done)> next;
    /// A task's row is on the disk: `reason` is why it failed, empty where it is done.
    std::function<void(const Task&, const std::string& reason)> finished;
};

/// What a run of a shard left: its tasks by what is now known of them.
struct ShardCounts {
    std::size_t done = 0, failed = 0, left = 0;
};
ShardCounts counts_of(const Plan& plan, const Shard& shard, const RunLogs& logs);

/// Fits what is left of a shard. A file is read once for all its tasks. Several devices take whole
/// files where there are enough, otherwise they share the fits to each. Each finished task is a
/// line of the shard's log, on the disk before the next begins; a task that fails is one with its
/// reason, and the others go on. What any log of the run has is not made again. Where nothing is
/// left, the file done_path says so. Throws InputError where the shard is being run by another
/// process, and where a log cannot be written; what was finished before stays.
ShardCounts run_shard(const Plan& plan, const std::string& folder, FitDevices& devices,
                      const RunOptions& options);

} // namespace brdfit

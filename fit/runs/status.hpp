#pragma once

#include "fit/runs/run.hpp"

#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A shard that was begun.
struct ShardStatus {
    Shard shard;
    ShardCounts counts;       ///< of its tasks, whoever made them
    std::size_t rows = 0;     ///< in its log
    bool running = false;     ///< by a process of this machine, or of one whose locks it sees
    double rate = 0;          ///< tasks a second of late; 0: unknown
    double last_finished = 0; ///< seconds since 1970; 0: nothing
};

/// How far a run is.
struct RunStatus {
    ShardCounts counts; ///< of all tasks of the plan
    std::vector<ShardStatus> shards;
    double rate = 0;                    ///< tasks a second of late, of the shards that run
    std::optional<double> seconds_left; ///< where shards run and their rate is known
    std::vector<BrokenLine> broken;
    std::size_t rows_of_no_task = 0; ///< of tasks that the plan has not, of an earlier one say
};

RunStatus status_of(const Plan& plan, const std::string& folder);

/// For people, a line a shard, and for programs.
std::string status_text(const RunStatus& status);
Json to_json(const RunStatus& status);

/// What is said of broken lines; empty where there are none.
std::string broken_text(const std::vector<BrokenLine>& broken);

} // namespace brdfit

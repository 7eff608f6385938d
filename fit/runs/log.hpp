#pragma once

#include "fit/runs/plan.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

// The logs of a run, one a shard: FOLDER/shards/0-of-4.jsonl. A line is a task that was finished,
// as a JSON object that ends with the CRC-32 of all before it:
//     {"id":"...","state":"done","finished":1.7e9,...,"crc32":"0badcafe"}

namespace brdfit {

/// The line for a row, which begins with id, state and finished.
std::string sealed(const Json& row);

enum class RowState { Done, Failed };

/// A line of a log whose checksum is right.
struct LoggedRow {
    std::string id;
    RowState state;
    double finished;      ///< seconds since 1970
    std::size_t line;     ///< number in its log, from 1
    std::uint64_t offset; ///< in the log, bytes
    std::uint64_t bytes;  ///< without the end of the line
};

/// What a line is, but its place; none where it is broken.
std::optional<LoggedRow> parse_logged(std::string_view line);

/// A line that is none of a run's: a flipped bit, say.
struct BrokenLine {
    std::string path;
    std::size_t line;
};

/// A log as it is now.
struct ShardLog {
    std::string path;
    Shard shard;
    std::vector<LoggedRow> rows;
    std::vector<BrokenLine> broken;
    std::uint64_t whole_bytes = 0; ///< without a torn last line
    bool torn = false;             ///< whether there is one: being written, or cut

    /// The row whole, without its checksum. Throws InputError where the log is not as it was when
    /// it was read.
    Json read(const LoggedRow& row) const;
    /// "PATH:LINE"
    std::string place(const LoggedRow& row) const;
};

/// Where the log of a shard is.
std::string log_path(const std::string& folder, const Shard& shard);
/// Reads one, which may be missing. Throws InputError where it cannot be read.
ShardLog read_log(const std::string& folder, const Shard& shard);

/// A row in one of several logs.
struct RowPlace {
    std::size_t log, row;
};

/// What is known of a task.
struct Finished {
    std::vector<RowPlace> done;     ///< more than one where shards of different runs overlapped
    std::optional<RowPlace> failed; ///< the last time
};

/// All logs of a run, by number of shards and shard, and what they know of each task by its id.
struct RunLogs {
    std::vector<ShardLog> logs;
    std::unordered_map<std::string, Finished> tasks;

    bool done(const std::string& id) const;
    bool failed(const std::string& id) const; ///< and not done
    const LoggedRow& at(const RowPlace& place) const { return logs[place.log].rows[place.row]; }
    Json read(const RowPlace& place) const { return logs[place.log].read(at(place)); }
    std::string name(const RowPlace& place) const { return logs[place.log].place(at(place)); }
    std::vector<BrokenLine> broken() const;
};
RunLogs read_logs(const std::string& folder);

/// The file that says that nothing is left of a shard.
std::string done_path(const std::string& folder, const Shard& shard);

} // namespace brdfit

#include "fit/runs/status.hpp"

#include "host/files/append.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <unordered_set>

namespace brdfit {

namespace {

// Of late: the last rows of a log, and seconds back from its last one.
constexpr std::size_t recent_rows = 200;
constexpr double recent_seconds = 600;

double rate_of(const std::vector<LoggedRow>& rows) {
    if (rows.size() < 2)
        return 0;
    const double last = rows.back().finished;
    std::size_t count = 0;
    double first = last;
    for (auto row = rows.rbegin() + 1;
         row != rows.rend() && count < recent_rows && row->finished <= first &&
         row->finished >= last - recent_seconds;
         ++row, ++count)
        first = row->finished;
    return last > first ? static_cast<double>(count) / (last - first) : 0;
}

std::string duration_text(double seconds) {
    const auto whole = static_cast<long>(std::ceil(seconds));
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

Json to_json(const ShardCounts& counts) {
    return {{"tasks", counts.done + counts.failed + counts.left},
            {"done", counts.done},
            {"failed", counts.failed},
            {"left", counts.left}};
}

std::string counts_text(const ShardCounts& counts) {
    return fmt::format("{:>6} {:>7} {:>6}", counts.done, counts.failed, counts.left);
}

} // namespace

RunStatus status_of(const Plan& plan, const std::string& folder) {
    const RunLogs logs = read_logs(folder);
    RunStatus status;
    status.counts = counts_of(plan, {}, logs);
    status.broken = logs.broken();
    std::unordered_set<std::string> known;
    for (const Task& task : plan.tasks)
        known.insert(task.id);
    double longest = 0;
    bool all_rates = true;
    for (const ShardLog& log : logs.logs) {
        for (const LoggedRow& row : log.rows)
            status.rows_of_no_task += known.count(row.id) == 0 ? 1 : 0;
        ShardStatus shard{log.shard,         counts_of(plan, log.shard, logs),
                          log.rows.size(),   is_being_appended(log.path),
                          rate_of(log.rows), log.rows.empty() ? 0 : log.rows.back().finished};
        if (shard.running && shard.counts.left > 0) {
            status.rate += shard.rate;
            all_rates = all_rates && shard.rate > 0;
            longest = std::max(longest, static_cast<double>(shard.counts.left) / shard.rate);
        }
        status.shards.push_back(shard);
    }
    if (status.rate > 0 && all_rates)
        status.seconds_left = longest;
    return status;
}

std::string broken_text(const std::vector<BrokenLine>& broken) {
    return broken.empty()
               ? ""
               : fmt::format("{}:{}: the checksum is wrong{}; its task counts as not done",
                             broken.front().path, broken.front().line,
                             broken.size() == 1
                                 ? ""
                                 : fmt::format(", and of {} lines more", broken.size() - 1));
}

std::string status_text(const RunStatus& status) {
    std::string text = fmt::format("{:<14} {:>6} {:>7} {:>6} {:>8}\n", "shard", "done", "failed",
                                   "left", "tasks/s");
    for (const ShardStatus& shard : status.shards)
        text += fmt::format("{:<14} {} {:>8}  {}\n", shard.shard.name(), counts_text(shard.counts),
                            shard.rate > 0 ? fmt::format("{:.2f}", shard.rate) : "-",
                            shard.running            ? "running"
                            : shard.counts.left == 0 ? "finished"
                                                     : "not running");
    text += fmt::format("{:<14} {} {:>8}", "all", counts_text(status.counts),
                        status.rate > 0 ? fmt::format("{:.2f}", status.rate) : "-");
    if (status.seconds_left)
        text += fmt::format("  {} left", duration_text(*status.seconds_left));
    text += '\n';
    if (status.rows_of_no_task > 0)
        text += fmt::format("{} rows are of tasks that the plan has not\n", status.rows_of_no_task);
    if (!status.broken.empty())
        text += broken_text(status.broken) + '\n';
    return text;
}

Json to_json(const RunStatus& status) {
    Json json = to_json(status.counts);
    json["tasks_per_second"] = status.rate;
    json["seconds_left"] = nullptr;
    if (status.seconds_left)
        json["seconds_left"] = *status.seconds_left;
    json["shards"] = Json::array();
    for (const ShardStatus& shard : status.shards) {
        Json entry = {{"shard", shard.shard.name()}};
        entry.update(to_json(shard.counts));
        entry["rows"] = shard.rows;
        entry["running"] = shard.running;
        entry["tasks_per_second"] = shard.rate;
        entry["last_finished"] = shard.last_finished;
        json["shards"].push_back(std::move(entry));
    }
    json["broken_lines"] = Json::array();
    for (const BrokenLine& line : status.broken)
        json["broken_lines"].push_back({{"log", line.path}, {"line", line.line}});
    json["rows_of_no_task"] = status.rows_of_no_task;
    return json;
}

} // namespace brdfit

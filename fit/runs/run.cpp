#include "fit/runs/run.hpp"

#include "fit/fit_all.hpp"
#include "fit/report.hpp"
#include "host/device/errors.hpp"
#include "host/error.hpp"
#include "host/files/append.hpp"
#include "host/measured/read.hpp"

#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <spdlog/spdlog.h>
#include <thread>
#include <unistd.h>
#include <unordered_set>

namespace brdfit {

namespace {

double now() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

std::string host_name() {
    char name[256] = "";
    return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

// Tasks on one file, one after the other.
using FileTasks = std::vector<const Task*>;

// The tasks of a shard that are to be made, by file; copies of a file are one.
std::vector<FileTasks> work_of(const Plan& plan, const RunLogs& logs, const RunOptions& options) {
    std::vector<FileTasks> files;
    std::unordered_map<std::string, std::size_t> of_digest;
    std::unordered_set<std::string> taken;
    for (const std::size_t t : tasks_of(plan, options.shard)) {
        const Task& task = plan.tasks[t];
        if (logs.done(task.id) || (logs.failed(task.id) && !options.retry_failed) ||
            !taken.insert(task.id).second)
            continue;
        const auto [place, is_new] = of_digest.emplace(plan.files[task.file].sha256, files.size());
        if (is_new)
            files.emplace_back();
        files[place->second].push_back(&task);
    }
    return files;
}

// Files for each device that are enough for it to take whole ones, which spares copies of their
// samples on the others; but the last one is waited for.
constexpr std::size_t enough_files = 3;

class Runner {
  public:
    Runner(const Plan& plan, FitDevices& devices, const RunOptions& options, AppendFile& log,
           const std::vector<FileTasks>& files)
        : plan_(plan), devices_(devices), options_(options), log_(log), files_(files),
          jobs_(static_cast<std::size_t>(std::max(options.jobs, 1))), host_(host_name()) {
        for (const FileTasks& file : files)
            left_ += cost(file);
    }

    // Fits files until none is left or it is time to stop, several at once.
    void run() {
        const bool whole = files_.size() >= enough_files * devices_.size();
        std::vector<Home> homes; // of the threads
        for (std::size_t job = 0; job < jobs_; ++job)
            for (std::size_t d = 0; d < (whole ? devices_.size() : 1); ++d)
                homes.push_back(whole ? Home(d) : std::nullopt);
        homes.resize(std::min(homes.size(), files_.size()));
        // Again where devices left files to others that had ended.
        while (next_file_ < files_.size() && !stopping()) {
            std::vector<std::thread> threads;
            for (std::size_t i = 1; i < homes.size(); ++i)
                try {
                    threads.emplace_back([this, home = homes[i]] { work(home); });
                } catch (const std::exception&) { // no more threads or memory
                    work(homes[i]);
                }
            work(homes[0]);
            for (std::thread& thread : threads)
                thread.join();
        }
        if (failure_)
            std::rethrow_exception(failure_);
    }

  private:
    // The device whose files a thread fits; none: all devices share them.
    using Home = std::optional<std::size_t>;

    static double cost(const FileTasks& file) {
        double sum = 0;
        for (const Task* task : file)
            sum += task->cost();
        return sum;
    }

    // The next file for a thread, or nullptr.
    const FileTasks* take(const Home& home) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (next_file_ == files_.size() || stopping())
            return nullptr;
        const FileTasks& file = files_[next_file_];
        const std::vector<bool> all(devices_.size(), true);
        if (home && !devices_.pays(*home, cost(file), left_, all, 1 / static_cast<double>(jobs_)))
            return nullptr;
        ++next_file_;
        left_ -= cost(file);
        return &file;
    }

    void work(const Home& home) {
        try {
            while (const FileTasks* file = take(home))
                fit_file(home, *file);
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!failure_)
                failure_ = std::current_exception();
            stopped_ = true;
        }
    }

    bool stopping() const { return stopped_ || (options_.stop && options_.stop()); }

    void fit_file(const Home& home, const FileTasks& tasks) {
        const PlannedFile& file = plan_.files[tasks.front()->file];
        std::optional<Samples> samples;
        std::string unreadable;
        try {
            samples.emplace(read_samples(plan_.path_of(file), plan_.settings.isotropic));
            if (samples->sha256 != file.sha256)
                throw InputError(fmt::format("{}: has changed since the plan: its SHA-256 is {}, "
                                             "expected {}",
                                             file.path, samples->sha256, file.sha256));
            samples->source = file.path;
            if (plan_.settings.orient && samples->isotropic)
                spdlog::warn("{}: is isotropic, so that --orient has nothing to turn", file.path);
        } catch (const std::exception& error) {
            unreadable = message_of(error);
        }
        std::vector<std::optional<DeviceSamples>> packed; // for all metrics
        for (std::size_t first = 0; first < tasks.size();) {
            const Metric metric = tasks[first]->metric;
            const auto end =
                std::find_if(tasks.begin() + static_cast<std::ptrdiff_t>(first), tasks.end(),
                             [&](const Task* task) { return task->metric != metric; });
            const FileTasks of_metric(tasks.begin() + static_cast<std::ptrdiff_t>(first), end);
            first += of_metric.size();
            if (unreadable.empty())
                fit_tasks(home, of_metric, *samples, packed);
            else
                fail(of_metric, unreadable);
        }
    }

    // Fits the tasks of one metric, several at once.
    void fit_tasks(const Home& home, FileTasks tasks, const Samples& samples,
                   std::vector<std::optional<DeviceSamples>>& packed) {
        std::vector<Structure> structures;
        for (const Task* task : tasks)
            structures.push_back(formed(plan_.settings, task->structure, samples.isotropic));
        FitCalls calls;
        calls.next = [&](std::size_t i) { return begin(*tasks[i]); };
        calls.done = [&](FitOutcome outcome) {
            const Task& task = *std::exchange(tasks[outcome.index], nullptr);
            std::optional<Json> row;
            std::string reason;
            try {
                if (outcome.failure)
                    std::rethrow_exception(outcome.failure);
                row = row_of(task, std::move(*outcome.result), samples, *outcome.device);
            } catch (const std::exception& error) {
                reason = message_of(error);
            }
            if (row)
                record(task, *row, "");
            else
                record_failure(task, reason);
        };
        calls.stop = [&] { return stopping(); };
        FitOptions fit_options = plan_.options_of(*tasks.front());
        fit_options.abandon = options_.abandon;
        const FitPlace place{home, jobs_, static_cast<std::size_t>(options_.fits_at_once), &packed};
        const std::exception_ptr hindrance =
            fit_all(devices_, samples, fit_options, structures, place, calls);
        if (hindrance)
            fail(tasks, message_of(hindrance));
    }

    // Tasks that cannot be begun; nullptr: one that was made.
    void fail(const FileTasks& tasks, const std::string& reason) {
        for (const Task* task : tasks)
            if (task != nullptr && !stopping()) {
                begin(*task);
                record_failure(*task, reason);
            }
    }

    ProgressFunction begin(const Task& task) {
        const std::lock_guard<std::mutex> lock(mutex_);
        return options_.next ? options_.next(task, finished_) : ProgressFunction{};
    }

    Json head(const Task& task, const char* state) const {
        return {{"id", task.id},
                {"state", state},
                {"finished", now()},
                {"shard", options_.shard.name()},
                {"host", host_}};
    }

    // Everything that is to be known of a fit: its material file as `fit` writes it, and what that
    // does not say.
    Json row_of(const Task& task, FitResult result, const Samples& samples,
                const Device& device) const {
        result.material.fit = fit_record(result, samples, plan_.options_of(task), device);
        Json row = head(task, "done");
        row["times"] = {{"build_seconds", result.build_seconds},
                        {"search_seconds", result.search_seconds},
                        {"polish_seconds", result.polish_seconds},
                        {"samples_per_second", result.samples_per_second()}};
        row["thinned_evaluations"] = result.thinned_evaluations;
        row["material"] = to_json(result.material);
        return row;
    }

    void record_failure(const Task& task, const std::string& reason) {
        Json row = head(task, "failed");
        row["reason"] = reason;
        record(task, row, reason);
    }

    void record(const Task& task, const Json& row, const std::string& reason) {
        const std::string line = sealed(row);
        const std::lock_guard<std::mutex> lock(mutex_);
        log_.append(line);
        ++finished_;
        if (options_.finished)
            options_.finished(task, reason);
    }

    const Plan& plan_;
    FitDevices& devices_;
    const RunOptions& options_;
    AppendFile& log_;
    const std::vector<FileTasks>& files_;
    const std::size_t jobs_;
    const std::string host_;
    std::atomic<bool> stopped_{false};
    std::mutex mutex_; // of all below, the log and the functions of the options
    std::size_t next_file_ = 0;
    double left_ = 0; // what the files from there on cost
    std::size_t finished_ = 0;
    std::exception_ptr failure_;
};

} // namespace

ShardCounts counts_of(const Plan& plan, const Shard& shard, const RunLogs& logs) {
    ShardCounts counts;
    for (const std::size_t t : tasks_of(plan, shard)) {
        const std::string& id = plan.tasks[t].id;
        ++(logs.done(id) ? counts.done : logs.failed(id) ? counts.failed : counts.left);
    }
    return counts;
}

ShardCounts run_shard(const Plan& plan, const std::string& folder, FitDevices& devices,
                      const RunOptions& options) {
    const std::string path = log_path(folder, options.shard);
    make_output_folder(std::filesystem::path(path).parent_path().string());
    sync_folder(folder);
    AppendFile log(path);
    const RunLogs before = read_logs(folder);
    for (const ShardLog& known : before.logs)
        if (known.path == path && known.torn)
            log.cut(known.whole_bytes);
    const std::vector<FileTasks> files = work_of(plan, before, options);
    std::size_t tasks = 0;
    for (const FileTasks& of_file : files)
        tasks += of_file.size();
    if (options.begin)
        options.begin(tasks);
    const std::string done = done_path(folder, options.shard);
    std::error_code was_none;
    std::filesystem::remove(done, was_none);
    if (tasks > 0)
        Runner(plan, devices, options, log, files).run();
    const ShardCounts counts = counts_of(plan, options.shard, read_logs(folder));
    if (counts.left == 0) {
        OutputFile file(done);
        file.write(fmt::format("{} done, {} failed\n", counts.done, counts.failed));
        file.commit(true);
    }
    return counts;
}

} // namespace brdfit

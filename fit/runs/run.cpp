#include "fit/runs/run.hpp"

#include "fit/programs.hpp"
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

class Runner {
  public:
    Runner(const Plan& plan, const Device& device, const RunOptions& options, AppendFile& log)
        : plan_(plan), device_(device), options_(options), log_(log), programs_(device),
          host_(host_name()) {}

    // Fits files until none is left or it is time to stop, `jobs` at once.
    void run(const std::vector<FileTasks>& files) {
        std::vector<std::thread> threads;
        const auto jobs =
            std::min(static_cast<std::size_t>(std::max(options_.jobs, 1)), files.size());
        threads.reserve(jobs);
        try {
            for (std::size_t i = 1; i < jobs; ++i)
                threads.emplace_back([&] { work(files); });
        } catch (const std::exception&) { // no more threads or memory: those there do it all
        }
        work(files);
        for (std::thread& thread : threads)
            thread.join();
        if (failure_)
            std::rethrow_exception(failure_);
    }

  private:
    void work(const std::vector<FileTasks>& files) {
        try {
            Device device =
                device_; // with a queue of its own, so that files do not wait for others
            device.queue = cl::CommandQueue(device.context, device.handle);
            for (std::size_t i = next_file_++; i < files.size() && !stopping(); i = next_file_++)
                fit_file(device, files[i]);
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!failure_)
                failure_ = std::current_exception();
            stopped_ = true;
        }
    }

    bool stopping() const { return stopped_ || (options_.stop && options_.stop()); }

    void fit_file(const Device& device, const FileTasks& tasks) {
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
        } catch (const std::exception& error) {
            unreadable = message_of(error);
        }
        for (std::size_t first = 0; first < tasks.size();) {
            const Metric metric = tasks[first]->metric;
            const auto end =
                std::find_if(tasks.begin() + static_cast<std::ptrdiff_t>(first), tasks.end(),
                             [&](const Task* task) { return task->metric != metric; });
            const FileTasks of_metric(tasks.begin() + static_cast<std::ptrdiff_t>(first), end);
            first += of_metric.size();
            const std::string problem =
                unreadable.empty() ? fit_tasks(device, of_metric, *samples) : unreadable;
            if (!problem.empty())
                for (const Task* task : of_metric)
                    if (!stopping())
                        fail(*task, problem);
        }
    }

    // Fits the tasks of one metric, several at once. Returns what hinders all of them, or nothing.
    std::string fit_tasks(const Device& device, const FileTasks& tasks, const Samples& samples) {
        std::optional<FileFitter> fitter;
        std::vector<Structure> structures;
        for (const Task* task : tasks)
            structures.push_back(formed(plan_.settings, task->structure, samples.isotropic));
        try {
            fitter.emplace(device, programs_, samples, plan_.options_of(*tasks.front()));
        } catch (const std::exception& error) {
            return message_of(error);
        }
        const auto at_once = static_cast<std::size_t>(options_.fits_at_once);
        const auto jobs = static_cast<std::size_t>(std::max(options_.jobs, 1));
        fitter->fit_all(
            structures,
            at_once > 0 ? at_once : std::max<std::size_t>(fits_at_once(device) / jobs, 1),
            [&](std::size_t i) { return begin(*tasks[i]); },
            [&](FitOutcome outcome) {
                const Task& task = *tasks[outcome.index];
                std::optional<Json> row;
                std::string reason;
                try {
                    if (outcome.failure)
                        std::rethrow_exception(outcome.failure);
                    row = row_of(task, std::move(*outcome.result), samples);
                } catch (const std::exception& error) {
                    reason = message_of(error);
                }
                if (row)
                    record(task, *row, "");
                else
                    record_failure(task, reason);
            },
            [&] { return stopping(); });
        return "";
    }

    void fail(const Task& task, const std::string& reason) {
        begin(task);
        record_failure(task, reason);
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
    Json row_of(const Task& task, FitResult result, const Samples& samples) const {
        result.material.fit = fit_record(result, samples, plan_.options_of(task), device_);
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
    const Device& device_;
    const RunOptions& options_;
    AppendFile& log_;
    ProgramCache programs_;
    const std::string host_;
    std::atomic<std::size_t> next_file_{0};
    std::atomic<bool> stopped_{false};
    std::mutex mutex_; // of all below, the log and the functions of the options
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

ShardCounts run_shard(const Plan& plan, const std::string& folder, const Device& device,
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
        Runner(plan, device, options, log).run(files);
    const ShardCounts counts = counts_of(plan, options.shard, read_logs(folder));
    if (counts.left == 0) {
        OutputFile file(done);
        file.write(fmt::format("{} done, {} failed\n", counts.done, counts.failed));
        file.commit(true);
    }
    return counts;
}

} // namespace brdfit

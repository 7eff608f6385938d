#include "fit/runs/run.hpp"
#include "fit/runs/status.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"

#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <fmt/format.h>
#include <optional>
#include <spdlog/spdlog.h>
#include <thread>

namespace brdfit::cli {

namespace {

struct Options {
    std::string folder, shard = "0/1";
    int jobs = 1;
    double max_time = 0; // seconds; 0: as long as it takes
    bool retry_failed = false;
};

Shard parse_shard(const std::string& text) {
    Shard shard;
    const char* const end = text.data() + text.size();
    const auto number = std::from_chars(text.data(), end, shard.number);
    if (number.ec == std::errc{} && number.ptr != end && *number.ptr == '/') {
        const auto count = std::from_chars(number.ptr + 1, end, shard.count);
        if (count.ec == std::errc{} && count.ptr == end && shard.number < shard.count &&
            shard.count <= most_shards)
            return shard;
    }
    throw UsageError(fmt::format("--shard {}: expected I/N, I from 0 to N - 1, N at most {}", text,
                                 most_shards));
}

// While it lives, SIGTERM and SIGINT ask for a stop after the current task, and a second one ends
// the program. A thread waits for them, and all others block them: a compiler in a driver has
// handlers that remove its files when a signal comes, and then fails the task. What was ignored
// (nohup) stays so. To be made before there are other threads.
class StopSignals {
  public:
    explicit StopSignals(bool quiet) : quiet_(quiet) {
        sigset_t both;
        sigemptyset(&both);
        sigemptyset(&awaited_);
        for (const int signal : {SIGINT, SIGTERM}) {
            struct sigaction before {};
            sigaction(signal, nullptr, &before);
            sigaddset(&both, signal);
            if (before.sa_handler != SIG_IGN)
                sigaddset(&awaited_, signal);
        }
        pthread_sigmask(SIG_BLOCK, &both, &mask_before_);
        thread_ = std::thread([this] { wait(); });
    }
    ~StopSignals() {
        ended_ = true;
        thread_.join();
        pthread_sigmask(SIG_SETMASK, &mask_before_, nullptr);
    }
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    bool asked() const { return asked_; }

  private:
    void wait() {
        constexpr timespec between_looks{0, 50000000};
        while (!ended_) {
            const int signal = sigtimedwait(&awaited_, nullptr, &between_looks);
            if (signal <= 0)
                continue;
            const bool again = asked_.exchange(true);
            if (again && signal == SIGINT)
                end(signal);
            if (!again && !quiet_)
                fmt::print(stderr, "\nbrdfit: info: stopping after the current task{}\n",
                           signal == SIGINT ? "; Ctrl-C once more: at once" : "");
        }
    }
    [[noreturn]] void end(int signal) const {
        remove_open_temporaries();
        std::signal(signal, SIG_DFL);
        pthread_sigmask(SIG_UNBLOCK, &awaited_, nullptr);
        for (;;)
            std::raise(signal);
    }

    const bool quiet_;
    sigset_t awaited_{}, mask_before_{};
    std::atomic<bool> asked_{false}, ended_{false};
    std::thread thread_;
};

// "plastic.binary kurt 1", with the metric where the plan has several.
std::string name_of(const Plan& plan, const Task& task) {
    return fmt::format("{} {} {}{}", plan.files[task.file].path, task.structure.name(),
                       task.structure.lobes.size(),
                       plan.metrics.size() > 1 ? fmt::format(" {}", name_of(task.metric)) : "");
}

int run_shard(const Options& options, const Globals& globals) {
    const auto started = std::chrono::steady_clock::now();
    RunOptions run;
    run.shard = parse_shard(options.shard);
    run.jobs = options.jobs;
    run.retry_failed = options.retry_failed;
    const Plan plan = read_plan(options.folder);
    const StopSignals signals(globals.quiet); // before the device: drivers make threads
    FitDevices devices(open_devices(globals.device));
    run.stop = [&] {
        const std::chrono::duration<double> so_far = std::chrono::steady_clock::now() - started;
        return signals.asked() || (options.max_time > 0 && so_far.count() >= options.max_time);
    };
    std::optional<Progress> progress;
    run.begin = [&](std::size_t tasks) { progress.emplace(tasks, globals.quiet); };
    run.next = [&](const Task& task, std::size_t done) {
        // The share of one task says nothing where several are at work.
        if (options.jobs == 1 && devices.size() == 1)
            return progress->step(done, name_of(plan, task));
        progress->show(done, name_of(plan, task));
        return ProgressFunction{};
    };
    std::string told; // a broken file fails every task on it
    run.finished = [&](const Task& task, const std::string& reason) {
        const bool is_new = !reason.empty() && reason != told;
        if (is_new || globals.verbose)
            progress->clear();
        spdlog::debug("{} {} {}", reason.empty() ? "done" : "failed", task.id, name_of(plan, task));
        if (is_new)
            spdlog::error("{}: {}", name_of(plan, task), reason);
        told = reason;
    };
    const ShardCounts counts = brdfit::run_shard(plan, options.folder, devices, run);
    progress->clear();
    fmt::print("shard {}: {} done, {} failed, {} left\n", run.shard.name(), counts.done,
               counts.failed, counts.left);
    if (counts.left > 0)
        spdlog::info("the same command goes on with what is left");
    if (counts.failed > 0 && !options.retry_failed)
        spdlog::info("--retry-failed tries those that failed again");
    return counts.left == 0 && counts.failed > 0 ? 1 : 0;
}

} // namespace

void add_run_shard(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("run", "Make the fits of a plan, or what is left of them");
    auto options = std::make_shared<Options>();
    command->add_option("RUN", options->folder, "folder that brdfit plan wrote")->required();
    command
        ->add_option("--shard", options->shard,
                     "I/N: of the plan in N parts the part I, from 0 to N - 1")
        ->capture_default_str();
    command->add_option("--jobs", options->jobs, "files fitted to at once")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command
        ->add_option("--max-time", options->max_time, "begin no task after so long: 90s, 45m, 3h")
        ->transform(
            CLI::AsNumberWithUnit(std::map<std::string, double>{{"s", 1}, {"m", 60}, {"h", 3600}}))
        ->check(CLI::PositiveNumber);
    command->add_flag("--retry-failed", options->retry_failed, "also tasks that failed before");
    command->footer("Example:\n  brdfit run run --shard 0/4\n"
                    "SIGTERM and SIGINT (Ctrl-C) stop after the current task; what is finished is "
                    "kept.");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return run_shard(*options, globals); };
    });
}

} // namespace brdfit::cli

#include "fit/cli/fit_options.hpp"
#include "fit/runs/log.hpp"
#include "fit/runs/slurm.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    FitSettings settings;
    std::vector<std::string> metrics{"ngan"};
    std::string folder;
    std::size_t shards = 0;
    bool slurm = false, force = false;
};

// Shards of an earlier plan may have something left again.
void remove_done_files(const std::string& folder) {
    std::error_code none;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(folder) / "shards", none))
        if (entry.path().extension() == ".done")
            std::filesystem::remove(entry.path(), none);
}

int plan(const Options& options, const Globals& globals) {
    std::vector<Metric> metrics;
    for (const std::string& name : options.metrics)
        if (const Metric metric = metric_named(name);
            std::find(metrics.begin(), metrics.end(), metric) == metrics.end())
            metrics.push_back(metric);
    if (options.shards > 0 && !options.slurm)
        throw UsageError("--shards: is of the script that --slurm writes; expected both");
    const FitRequest request = options.settings.request();
    if (!options.force)
        check_none_is_there({(std::filesystem::path(options.folder) / "plan.json").string()});
    Progress progress(1, globals.quiet);
    const Plan plan = make_plan(request, metrics, progress.step(0, "reading the files"));
    progress.clear();
    write_plan(plan, options.folder);
    remove_done_files(options.folder);
    const RunLogs logs = read_logs(options.folder);
    const auto done = std::count_if(plan.tasks.begin(), plan.tasks.end(),
                                    [&](const Task& task) { return logs.done(task.id); });
    fmt::print("{}: {} fits of {} files{}\n", options.folder, plan.tasks.size(), plan.files.size(),
               done > 0 ? fmt::format(", {} of them done already", done) : "");
    if (options.slurm) {
        const std::size_t shards = options.shards > 0 ? options.shards : slurm_shards(plan);
        fmt::print("sh {} submits {} shards to Slurm\n", write_slurm(options.folder, shards),
                   shards);
    }
    return 0;
}

} // namespace

void add_plan(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("plan", "Plan the fits of many files, for run, status and merge");
    auto options = std::make_shared<Options>();
    options->settings.add_to(*command);
    command
        ->add_option("--metric", options->metrics,
                     "what is minimised: ngan, l2, log, cbrt; several with commas between")
        ->allow_extra_args(false)
        ->delimiter(',')
        ->default_str("ngan");
    command->add_option("-o,--output", options->folder, "folder of the run")->required();
    command->add_flag("--slurm", options->slurm, "also write scripts for Slurm's sbatch");
    command->add_option("--shards", options->shards, "with --slurm: how many shards")
        ->check(CLI::Range(std::size_t{1}, most_shards));
    command->add_flag("--force", options->force, "replace the plan; fits that both have stay done");
    command->footer("Example:\n  brdfit plan merl/*.binary -m all --lobes 1,2 -o run\n"
                    "  brdfit run run --shard 0/4   # and 1/4, 2/4, 3/4, at once or one by one\n"
                    "  brdfit merge run -o results.sqlite");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return plan(*options, globals); };
    });
}

} // namespace brdfit::cli

#include "fit/runs/merge.hpp"
#include "fit/runs/status.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string folder;
    MergeOutputs outputs;
    bool force = false;
};

void check(const Options& options, const Plan& plan) {
    const MergeOutputs& outputs = options.outputs;
    if (outputs.database.empty() && outputs.csv.empty() && outputs.materials.empty())
        throw UsageError("merge: nothing is asked for; expected -o, --csv or --materials");
    if (outputs.best && outputs.materials.empty())
        throw UsageError("--best: is of the materials; expected it with --materials");
    const std::filesystem::path ending = std::filesystem::path(outputs.database).extension();
    if (!outputs.database.empty() && ending != ".sqlite" && ending != ".sqlite3" && ending != ".db")
        throw UsageError(fmt::format("-o {}: unknown ending; expected .sqlite, .sqlite3 or .db",
                                     outputs.database));
    if (!outputs.csv.empty() && std::filesystem::path(outputs.csv).extension() != ".csv")
        throw UsageError(fmt::format("--csv {}: unknown ending; expected .csv", outputs.csv));
    std::error_code unknown;
    if (std::filesystem::is_other(outputs.database, unknown))
        throw UsageError(
            fmt::format("-o {}: is no regular file; SQLite writes nothing else", outputs.database));
    if (options.force || outputs.materials.empty())
        return;
    std::vector<std::string> paths;
    for (const Task& task : plan.tasks)
        paths.push_back((std::filesystem::path(outputs.materials) / task.output).string());
    check_none_is_there(paths);
}

void tell_what_was_found(const MergeReport& report) {
    if (!report.broken.empty())
        spdlog::warn("{}", broken_text(report.broken));
    if (report.left > 0)
        spdlog::warn("{} fits of the plan are not done yet", report.left);
    if (report.made_by.size() > 1) {
        spdlog::warn("the fits were made by {} devices, drivers or programs:",
                     report.made_by.size());
        for (const auto& [maker, fits] : report.made_by)
            spdlog::warn("  {} fits by {}", fits, maker);
    }
    if (report.largest_difference > 0)
        spdlog::warn("errors of fits that two of these made differ by {:.2g} at most, relative",
                     report.largest_difference);
}

int merge(const Options& options, const Globals& globals) {
    const Plan plan = read_plan(options.folder);
    check(options, plan);
    Progress progress(1, globals.quiet);
    const MergeReport report =
        merge_run(plan, options.folder, options.outputs, progress.step(0, "merging"));
    progress.clear();
    tell_what_was_found(report);
    fmt::print("{} done, {} failed, {} left", report.done, report.failed, report.left);
    if (report.duplicates > 0)
        fmt::print(", {} made twice with one result", report.duplicates);
    if (!options.outputs.materials.empty())
        fmt::print(", {} materials written", report.materials);
    fmt::print("\n");
    return 0;
}

} // namespace

void add_merge(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand("merge", "Collect the results of a run");
    auto options = std::make_shared<Options>();
    MergeOutputs& outputs = options->outputs;
    command->add_option("RUN", options->folder, "folder that brdfit plan wrote")->required();
    command->add_option("-o,--output", outputs.database,
                        ".sqlite, .sqlite3 or .db: settings, files, fits, parameters");
    command->add_option("--csv", outputs.csv, "table, one row a fit");
    command->add_option("--materials", outputs.materials, "folder for the material files");
    command->add_flag("--best", outputs.best,
                      "of these, for each file and metric, the fit of the least error only");
    command->add_flag("--force", options->force, "replace materials that exist");
    command->footer("Example:\n  brdfit merge run -o results.sqlite --csv results.csv");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return merge(*options, globals); };
    });
}

} // namespace brdfit::cli

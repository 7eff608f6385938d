#include "fit/python/call.hpp"
#include "fit/python/module.hpp"
#include "fit/report/page.hpp"
#include "fit/runs/log.hpp"
#include "fit/runs/merge.hpp"
#include "fit/runs/plan.hpp"
#include "fit/runs/run.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <spdlog/spdlog.h>

// Large runs: the results of one, a report of them, and its tasks one by one.

namespace brdfit::python {

namespace {

// A plan of that task alone. Its folder says where relative paths begin.
Plan plan_of(const Plan& plan, const Task& task) {
    Plan alone = plan;
    alone.files = {plan.files[task.file]};
    alone.tasks = {task};
    alone.tasks.front().file = 0;
    return alone;
}

// Reads the one task of a plan that write_plan wrote, runs it, and returns its row of the log.
std::string run_only_task(const std::string& folder, const Device& device, Call& call) {
    const Plan plan = read_plan(folder);
    if (plan.tasks.size() != 1)
        throw InputError(
            fmt::format("task: {} tasks; expected one, as tasks() gives it", plan.tasks.size()));
    RunOptions options;
    options.stop = options.abandon = [&] { return call.stopped(); };
    FitDevices devices({device});
    run_shard(plan, folder, devices, options);
    const RunLogs logs = read_logs(folder);
    const auto found = logs.tasks.find(plan.tasks.front().id);
    if (found == logs.tasks.end())
        return "";
    const Finished& known = found->second;
    Json row = logs.read(known.done.empty() ? *known.failed : known.done.front());
    row["file"] = plan.files.front().path;
    return dumped(row);
}

void write_report(const std::string& folder, const std::string& path, const Selection& selection,
                  ReportOptions options, const std::string& device, Call& call) {
    OutputFile file(path); // a path that cannot be written costs no time
    const Results results = read_results(folder, selection, call.progress());
    for (const std::string& note : results.notes)
        spdlog::warn("{}", note);
    options.next = [&](const std::string& material, std::size_t done) {
        const double share =
            static_cast<double>(done) / static_cast<double>(results.materials.size());
        call.progress()(share);
        call.say(share, material);
    };
    file.write(report_page(results, options, [&] { return opened(device); }));
    file.commit();
}

} // namespace

void add_runs(nb::module_& module) {
    module.def(
        "merge_to_csv",
        [](const std::string& run_folder, const std::string& csv, const nb::object& progress) {
            run(progress, [&](Call& call) {
                MergeOutputs outputs;
                outputs.csv = csv;
                merge_run(read_plan(run_folder), run_folder, outputs, call.progress());
            });
        },
        nb::arg("run"), nb::arg("csv"), nb::arg("progress").none());
    module.def(
        "report",
        [](const std::string& folder, const std::string& path,
           const std::vector<std::string>& materials, const std::vector<std::string>& models,
           const std::string& metric, const std::string& model, std::size_t size,
           std::size_t samples, const std::string& device, const nb::object& progress) {
            run(progress, [&](Call& call) {
                write_report(folder, path, {materials, models, metric}, {size, samples, model, {}},
                             device, call);
            });
        },
        nb::arg("folder"), nb::arg("path"), nb::arg("materials"), nb::arg("models"),
        nb::arg("metric"), nb::arg("model"), nb::arg("size"), nb::arg("samples"), nb::arg("device"),
        nb::arg("progress").none());
    module.def(
        "write_tasks",
        [](const std::string& run_folder, const std::string& folder) {
            return run(nb::none(), [&](Call&) {
                const Plan plan = read_plan(run_folder);
                std::vector<std::string> folders;
                for (const Task& task : plan.tasks) {
                    folders.push_back(
                        (std::filesystem::path(folder) / std::to_string(folders.size())).string());
                    write_plan(plan_of(plan, task), folders.back());
                }
                return folders;
            });
        },
        nb::arg("run"), nb::arg("folder"));
    module.def(
        "run_only_task",
        [](const std::string& folder, const std::string& device, const nb::object& progress) {
            return run(progress,
                       [&](Call& call) { return run_only_task(folder, opened(device), call); });
        },
        nb::arg("folder"), nb::arg("device"), nb::arg("progress").none());
}

} // namespace brdfit::python

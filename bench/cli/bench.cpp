#include "bench/again.hpp"
#include "bench/albedo.hpp"
#include "bench/formats.hpp"
#include "bench/native_tasks.hpp"
#include "bench/opencl.hpp"
#include "bench/render.hpp"
#include "bench/report.hpp"
#include "bench/whole.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

namespace brdfit::cli {

namespace {

struct Options {
    std::string json;
    std::vector<std::string> models, works;
    std::size_t samples = 0;
    std::string child; // which part this process is, "" for the whole
};

constexpr const char* one_thread_child = "one-thread"; // the baselines and the device on one

using bench::Problem;
using bench::Task;

// More than any processor's caches hold.
constexpr std::size_t bytes_read = std::size_t{1} << 28;
// The baselines are slow and steady: fewer runs do.
constexpr bench::Repeats scalar_repeats{1, 3, 20, 0.1};

/// Besides bench::works.
constexpr std::array<std::string_view, 7> other_works{
    bench::fit_work, bench::run_work,    bench::table_work, bench::read_work,
    bench::rgl_work, bench::render_work, "compile"};

bool wanted(const Options& options, const std::string& work) {
    return options.works.empty() ||
           std::find(options.works.begin(), options.works.end(), work) != options.works.end();
}

// Whether any work that is wanted is of a model.
bool model_wanted(const Options& options) {
    return wanted(options, bench::table_work) ||
           std::any_of(std::begin(bench::works), std::end(bench::works),
                       [&](const bench::Work& work) { return wanted(options, work.name); });
}

// The models to measure. Throws UsageError where one is unknown, or named though no work takes it.
std::vector<Problem> wanted_problems(const Options& options) {
    if (model_wanted(options))
        return bench::problems(options.models);
    if (!options.models.empty())
        throw UsageError(
            fmt::format("--model: --work {} is of no model", fmt::join(options.works, ",")));
    return {};
}

// Runs the tasks that are wanted.
void measure_tasks(const Options& options, const std::vector<Task>& tasks,
                   const std::string& device, int threads, const bench::Repeats& repeats,
                   std::vector<bench::Result>& results) {
    for (const Task& task : tasks)
        if (wanted(options, task.work))
            results.push_back(bench::measure(task, device, threads, repeats));
}

// What needs an environment of its own: the device on one thread, and with it, under the same
// conditions, the baselines.
int bench_as_child(const Device& device, const Options& options) {
    const bool one_thread = options.child == one_thread_child;
    const Samples data = bench::data_of(device, options.samples);
    const std::vector<bench::ScalarSample> samples = bench::scalar_samples(data);
    bench::Measured measured;
    std::vector<bench::Result>& results = measured.results;
    for (const Problem& problem : wanted_problems(options)) {
        measure_tasks(options, bench::scalar_tasks(problem, samples), bench::baseline, 1,
                      scalar_repeats, results);
        measure_tasks(options, {bench::precomputed_task(problem, samples)},
                      bench::precomputed_baseline, 1, scalar_repeats, results);
        for (const auto& [task, threads] : bench::simd_tasks(problem, samples))
            measure_tasks(options, {task}, bench::simd_baseline, threads, {}, results);
        if (one_thread)
            measure_tasks(options, bench::device_tasks(device, problem, data), device.name, 1, {},
                          results);
    }
    if (one_thread && wanted(options, bench::rgl_work) && options.samples == 0)
        results.push_back(bench::measure_rgl(device, 1));
    if (one_thread && wanted(options, bench::render_work) && options.samples == 0)
        results.push_back(bench::measure_render(device, 1));
    if (one_thread) {
        measured.peaks.push_back(bench::measure_peaks(device, bytes_read));
        measured.peaks.back().threads = 1;
    }
    fmt::print("{}\n", to_message(measured).dump());
    return 0;
}

bench::Measured measure_in_child(const Device& device, const Options& options) {
    auto variables = bench::one_thread_environment(device);
    std::vector<std::string> arguments = {"--device",
                                          std::to_string(device.index),
                                          "bench",
                                          "--child",
                                          variables.empty() ? "baselines" : one_thread_child,
                                          "--samples",
                                          std::to_string(options.samples)};
    for (const std::string& model : options.models)
        arguments.insert(arguments.end(), {"-m", model});
    for (const std::string& work : options.works)
        arguments.insert(arguments.end(), {"--work", work});
    // OpenMP's threads must sleep while they wait: spinning, they keep a busy machine's cores from
    // the thread waited for, and the baseline would look several times slower than it is.
    variables.emplace_back("OMP_WAIT_POLICY", "passive");
    const std::string text = bench::run_again(arguments, variables);
    try {
        return bench::measured_from_message(nlohmann::ordered_json::parse(text));
    } catch (const nlohmann::json::exception& error) {
        throw InputError(
            fmt::format("unexpected output of the benchmark's part: {}", error.what()));
    }
}

void append(bench::Measured& to, const bench::Measured& from) {
    to.results.insert(to.results.end(), from.results.begin(), from.results.end());
    to.peaks.insert(to.peaks.end(), from.peaks.begin(), from.peaks.end());
}

void measure_device(const Device& device, const Options& options, const Globals& globals,
                    bench::Report& report) {
    const std::vector<Problem> problems = wanted_problems(options);
    Progress progress(problems.size() + 7, globals.quiet);
    std::size_t done = 0;
    const Samples data = bench::data_of(device, options.samples);
    report.samples = data.valid_count();
    const int threads = static_cast<int>(device.compute_units);
    bench::Measured& measured = report.measured;
    const bool one_thread = !bench::one_thread_environment(device).empty();
    if (!one_thread || threads > 1) {
        for (const Problem& problem : problems) {
            progress.show(done++, problem.name());
            measure_tasks(options, bench::device_tasks(device, problem, data), device.name, threads,
                          {}, measured.results);
        }
        measured.peaks.push_back(bench::measure_peaks(device, bytes_read));
    }
    progress.show(problems.size(), "baselines and one thread");
    // The baselines are the same whatever the device.
    if (report.devices.size() == 1 || one_thread) {
        bench::Measured part = measure_in_child(device, options);
        if (report.devices.size() > 1)
            part.results.erase(
                std::remove_if(part.results.begin(), part.results.end(),
                               [&](const bench::Result& r) { return r.device != device.name; }),
                part.results.end());
        append(measured, part);
    }
    progress.show(problems.size() + 1, "albedo tables");
    if (wanted(options, bench::table_work) && options.samples == 0)
        for (const Problem& problem : problems)
            if (const Model* const model = find_model(problem.name());
                model != nullptr && model->kind == Kind::Lobe)
                append(measured, {{bench::measure_table(device, *model)}, {}});
    progress.show(problems.size() + 2, "whole fits");
    if (wanted(options, bench::fit_work) && options.samples == 0)
        append(measured, {bench::measure_fit(device, data), {}});
    progress.show(problems.size() + 3, "a run");
    if (wanted(options, bench::run_work) && options.samples == 0)
        append(measured, {bench::measure_run(device, data), {}});
    progress.show(problems.size() + 4, "files");
    if (wanted(options, bench::rgl_work) && options.samples == 0 && (!one_thread || threads > 1))
        append(measured, {{bench::measure_rgl(device, threads)}, {}});
    if (wanted(options, bench::read_work) && options.samples == 0 && report.devices.size() == 1)
        append(measured, {bench::measure_reading(device, data), {}});
    progress.show(problems.size() + 5, "pictures");
    if (wanted(options, bench::render_work) && options.samples == 0 && (!one_thread || threads > 1))
        append(measured, {{bench::measure_render(device, threads)}, {}});
    progress.show(problems.size() + 6, "compiling");
    if (wanted(options, "compile"))
        report.compile.push_back(bench::measure_compile(device));
}

int bench_command(const Options& options, const Globals& globals) {
    if (options.child == "compile") {
        fmt::print("{}\n", bench::build_and_run_kernels(open_device(globals.device)));
        return 0;
    }
    if (!options.child.empty())
        return bench_as_child(open_device(globals.device), options);
    for (const std::string& work : options.works)
        if (bench::find_work(work) == nullptr &&
            std::find(other_works.begin(), other_works.end(), work) == other_works.end())
            throw UsageError(fmt::format("--work {}: unknown; see brdfit bench --help", work));
    wanted_problems(options);
    std::optional<OutputFile> json; // opened first: a path that cannot be written costs no time
    if (!options.json.empty())
        json.emplace(options.json);
    bench::Report report;
    for (const Device& device : open_devices(globals.device)) {
        report.devices.push_back(device);
        measure_device(device, options, globals, report);
    }
    bench::check_answers(report.measured.results);
    print(report);
    if (json) {
        json->write(to_json(report).dump(2) + "\n");
        json->commit();
    }
    return 0;
}

} // namespace

void add_bench(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("bench", "Measure how fast devices evaluate, fit and sample each model, "
                                    "against plain C++ on this machine and what they do at most");
    auto options = std::make_shared<Options>();
    std::string names;
    for (const bench::Work& work : bench::works)
        names += std::string(work.name) + ", ";
    command->add_option("-m,--model", options->models, "models, with commas; default: all")
        ->delimiter(',')
        ->allow_extra_args(false);
    command
        ->add_option(
            "--work", options->works,
            fmt::format("with commas, of {}{}; default: all", names, fmt::join(other_works, ", ")))
        ->delimiter(',')
        ->allow_extra_args(false);
    command->add_option("--json", options->json, "file to write the results to, as JSON");
    command->add_option("--samples", options->samples)->group(""); // for tests
    command->add_option("--child", options->child)->group("");
    command->footer("--device all measures every device.\n"
                    "Example:\n  brdfit bench --device all --json bench.json");
    add_bench_sampling(*command, globals, action);
    add_bench_portability(*command, globals, action);
    add_bench_compare(*command, globals, action);
    command->callback([command, options, &globals, &action] {
        if (command->get_subcommands().empty()) {
            action = [options, &globals] { return bench_command(*options, globals); };
            return;
        }
        // That has set the action, and takes none of these.
        for (const char* name : {"--model", "--work", "--json"})
            if (command->count(name) > 0)
                throw CLI::ValidationError(name,
                                           "is an option of bench itself, not of bench " +
                                               command->get_subcommands().front()->get_name());
    });
}

} // namespace brdfit::cli

#include "bench/again.hpp"
#include "bench/native.hpp"
#include "bench/opencl.hpp"
#include "host/cli/command.hpp"
#include "host/error.hpp"
#include "host/file.hpp"
#include "host/version.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

namespace brdfit::cli {

namespace {

// An answer further than this from the baseline's is wrong.
constexpr double tolerance = 1e-4;
// What one thread of a processor is meant to reach, in error-gradient.
constexpr double least_ratio = 20, least_samples_per_second = 200e6;

struct Options {
    std::string json;
    std::size_t samples = 0;
    bool child = false;
};

using bench::Problem;
using bench::Result;

// The part that needs an environment of its own; its results are for the run that started it.
int bench_as_child(const Device& device, const Options& options) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    const auto append = [&](const std::vector<Result>& results) {
        for (const Result& result : results)
            rows.push_back(to_json(result, true));
    };
    for (const Problem& problem : bench::problems()) {
        const Samples data = bench::samples_of(device, problem, options.samples);
        if (bench::can_run_on_one_thread(device))
            append(bench::measure_device(device, problem, data));
        append(bench::measure_simd(problem, data));
    }
    fmt::print("{}\n", rows.dump());
    return 0;
}

std::vector<Result> measure_in_child(const Device& device, const Options& options) {
    std::vector<Result> results;
    // OpenMP's threads must sleep while they wait: spinning, they keep a busy machine's cores from
    // the thread waited for, and the baseline would look several times slower than it is.
    const std::string text =
        bench::run_again({"--device", std::to_string(device.index), "bench", "--child", "--samples",
                          std::to_string(options.samples)},
                         {{"POCL_MAX_PTHREAD_COUNT", "1"}, {"OMP_WAIT_POLICY", "passive"}});
    try {
        for (const auto& row : nlohmann::ordered_json::parse(text))
            results.push_back(bench::result_from_json(row));
    } catch (const nlohmann::json::exception& error) {
        throw InputError(
            fmt::format("unexpected output of the benchmark's part: {}", error.what()));
    }
    return results;
}

// The baseline's row for the same work and model, or nullptr.
const Result* baseline_of(const std::vector<Result>& results, const Result& result) {
    for (const Result& other : results)
        if (other.device == bench::baseline && other.work == result.work &&
            other.model == result.model)
            return &other;
    return nullptr;
}

void check_answers(std::vector<Result>& results) {
    for (Result& result : results) {
        const Result* const reference = baseline_of(results, result);
        if (reference == nullptr)
            continue;
        result.difference = bench::difference(result.answer, reference->answer);
        if (!(result.difference < tolerance))
            throw InputError(fmt::format("{} ({} threads), {} of {}: the answer differs from that "
                                         "of {} by {:.1e}; expected less than {:.0e}",
                                         result.device, result.threads, result.work, result.model,
                                         bench::baseline, result.difference, tolerance));
    }
}

void print_table(const std::vector<Result>& results, std::size_t samples) {
    std::size_t width = 0;
    for (const Result& result : results)
        width = std::max(width, result.device.size());
    fmt::print("{} samples of 3 channels (MERL grid); a run is one evaluation of a fit, median of "
               "repeated runs\n"
               "spread: distance of the quartiles; GB/s: sample data read; ratio: to {}\n\n",
               samples, bench::baseline);
    fmt::print("{:<14} {:<8} {:<{}} {:>7} {:>11} {:>7} {:>7} {:>7}\n", "work", "model", "device",
               width, "threads", "Msamples/s", "spread", "GB/s", "ratio");
    for (const bench::Work& work : bench::works)
        for (const Result& result : results) {
            if (result.work != work.name)
                continue;
            const Result* const reference = baseline_of(results, result);
            fmt::print(
                "{:<14} {:<8} {:<{}} {:>7} {:>11.1f} {:>6.1f}% {:>7.2f} {:>7}\n", result.work,
                result.model, result.device, width, result.threads, result.samples_per_second / 1e6,
                result.spread * 100, result.samples_per_second * result.bytes_per_sample / 1e9,
                reference == nullptr ? "-"
                                     : fmt::format("{:.1f}", result.samples_per_second /
                                                                 reference->samples_per_second));
        }
}

struct Target {
    std::string name;
    double value, least;
};

// What is asked of one thread of a processor, for each of its rows that has a baseline.
std::vector<Target> targets_of(const std::vector<Result>& results, const Device& device) {
    std::vector<Target> targets;
    for (const Result& result : results) {
        const Result* const reference = baseline_of(results, result);
        if (!device.cpu || result.device != device.name || result.threads != 1 ||
            result.work != "error-gradient" || reference == nullptr)
            continue;
        targets.push_back({fmt::format("error-gradient of {} on one thread, times {}", result.model,
                                       bench::baseline),
                           result.samples_per_second / reference->samples_per_second, least_ratio});
        targets.push_back(
            {fmt::format("error-gradient of {} on one thread, million samples/s", result.model),
             result.samples_per_second / 1e6, least_samples_per_second / 1e6});
    }
    return targets;
}

void write_json(OutputFile& file, const Device& device, std::size_t samples,
                const std::vector<Result>& results, const std::vector<Target>& targets) {
    const bench::NativeBuild build = bench::native_build();
    nlohmann::ordered_json json = {{"device", device.name},
                                   {"platform", device.platform},
                                   {"driver", device.driver},
                                   {"version", version},
                                   {"kernels", bench::kernel_hash()},
                                   {"machine", bench::processor_name()},
                                   {"compiler", build.compiler},
                                   {"native_flags", build.scalar_flags},
                                   {"simd_flags", nullptr},
                                   {"samples", samples},
                                   {"results", nlohmann::ordered_json::array()},
                                   {"targets", nlohmann::ordered_json::array()}};
    if (build.simd_flags != nullptr)
        json["simd_flags"] = build.simd_flags;
    for (const Result& result : results)
        json["results"].push_back(to_json(result, false));
    for (const Target& target : targets)
        json["targets"].push_back({{"name", target.name},
                                   {"value", target.value},
                                   {"least", target.least},
                                   {"met", target.value >= target.least}});
    file.write(json.dump(2) + "\n");
    file.commit();
}

int bench_command(const Options& options, const Globals& globals) {
    const Device device = open_device(globals.device);
    if (options.child)
        return bench_as_child(device, options);
    std::optional<OutputFile> json; // opened first: a path that cannot be written costs no time
    if (!options.json.empty())
        json.emplace(options.json);
    std::vector<Result> results;
    std::size_t samples = 0;
    const auto append = [&](std::vector<Result> more) {
        results.insert(results.end(), more.begin(), more.end());
    };
    for (const Problem& problem : bench::problems()) {
        const Samples data = bench::samples_of(device, problem, options.samples);
        samples = data.valid_count();
        if (!bench::can_run_on_one_thread(device) || device.compute_units > 1)
            append(bench::measure_device(device, problem, data));
        append(bench::measure_scalar(problem, data));
    }
    append(measure_in_child(device, options));
    std::stable_sort(results.begin(), results.end(), [](const Result& a, const Result& b) {
        return std::make_pair(a.device.rfind("native", 0) != 0, a.threads) <
               std::make_pair(b.device.rfind("native", 0) != 0, b.threads);
    });
    check_answers(results);

    const bench::NativeBuild build = bench::native_build();
    fmt::print("device: {} ({}, driver {})\nmachine: {}\nnative: {}, {}; simd: {}\n", device.name,
               device.platform, device.driver, bench::processor_name(), build.compiler,
               build.scalar_flags, build.simd_flags == nullptr ? "not built" : build.simd_flags);
    print_table(results, samples);
    const std::vector<Target> targets = targets_of(results, device);
    for (const Target& target : targets)
        fmt::print("\ntarget: {}: {:.1f}, at least {:.0f}: {}", target.name, target.value,
                   target.least, target.value >= target.least ? "met" : "missed");
    fmt::print("\n");
    if (json)
        write_json(*json, device, samples, results, targets);
    return 0;
}

} // namespace

void add_bench(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("bench", "Measure how fast a device evaluates error and gradient of a "
                                    "fit, against plain C++ on this machine");
    auto options = std::make_shared<Options>();
    command->add_option("--json", options->json, "file to write the results to, as JSON");
    command->add_option("--samples", options->samples)->group(""); // for tests
    command->add_flag("--child", options->child)->group("");
    command->footer("Example:\n  brdfit bench --json bench.json");
    add_bench_sampling(*command, globals, action);
    command->callback([command, options, &globals, &action] {
        if (command->get_subcommands().empty()) // otherwise that has set the action
            action = [options, &globals] { return bench_command(*options, globals); };
    });
}

} // namespace brdfit::cli

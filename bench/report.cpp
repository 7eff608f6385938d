#include "bench/report.hpp"

#include "bench/albedo.hpp"
#include "bench/formats.hpp"
#include "bench/native_tasks.hpp"
#include "bench/opencl.hpp"
#include "bench/render.hpp"
#include "bench/whole.hpp"
#include "host/device/kernels.hpp"
#include "host/device/tuning.hpp"
#include "host/error.hpp"
#include "host/model/structure.hpp"
#include "host/version.hpp"

#include <fmt/format.h>
#include <set>

namespace brdfit::bench {

namespace {

const Peaks* peaks_of(const Report& report, const std::string& device, int threads) {
    for (const Peaks& peaks : report.measured.peaks)
        if (peaks.device == device && peaks.threads == threads)
            return &peaks;
    return nullptr;
}

std::vector<std::string> models_of(const std::vector<Result>& results, const std::string& work) {
    std::vector<std::string> models;
    for (const Result& result : results)
        if (result.work == work &&
            std::find(models.begin(), models.end(), result.model) == models.end())
            models.push_back(result.model);
    return models;
}

std::string millions(const Result* result) {
    return result == nullptr ? "-" : fmt::format("{:.1f}", result->samples_per_second / 1e6);
}

std::string ratio(const Result* result, const Result* reference) {
    return result == nullptr || reference == nullptr
               ? "-"
               : fmt::format("{:.1f}", result->samples_per_second / reference->samples_per_second);
}

std::string percent(double share) {
    return fmt::format("{:.0f}%", 100 * share);
}

// One line: a model on one thread and on all, with the roofline of the latter.
void print_line(const Report& report, const std::string& name, const Result* scalar,
                const Result* one, const Result* all) {
    const Result* const last = all != nullptr ? all : one;
    if (last == nullptr)
        return;
    const Peaks* const peaks = peaks_of(report, last->device, last->threads);
    const bool bytes = last->bytes_per_sample > 0;
    fmt::print(
        "{:<20} {:>7} {:>9} {:>6} {:>9} {:>6} {:>6} {:>7} {:>7} {:>9} {:>7}\n", name,
        millions(scalar), millions(one), ratio(one, scalar), millions(all), ratio(all, scalar),
        bytes ? fmt::format("{:.1f}", last->samples_per_second * last->bytes_per_sample / 1e9)
              : "-",
        peaks ? percent(peaks->memory_share(*last)) : "-",
        peaks ? percent(peaks->calls_share(*last)) : "-", peaks ? peaks->binds(*last) : "-",
        percent(last->spread));
}

void print_device(const Report& report, const Device& device) {
    const std::vector<Result>& results = report.measured.results;
    const int all_threads = static_cast<int>(device.compute_units);
    fmt::print("\n{} ({}, driver {}), {} compute units\n", device.name, device.platform,
               device.driver, device.compute_units);
    for (const Peaks& peaks : report.measured.peaks)
        if (peaks.device == device.name)
            fmt::print(
                "{} thread{}: reads {:.1f} GB/s of {:.0f} MB, {:.1f} GB/s of {:.0f} MB; "
                "{:.2f} G exp/s, {:.2f} G log/s\n",
                peaks.threads, peaks.threads == 1 ? "" : "s",
                peaks.reading.back().bytes_per_second / 1e9, peaks.reading.back().bytes / 1e6,
                peaks.reading.front().bytes_per_second / 1e9, peaks.reading.front().bytes / 1e6,
                peaks.exp_per_second / 1e9, peaks.log_per_second / 1e9);
    if (device.cpu && one_thread_environment(device).empty())
        fmt::print(
            "1 thread: not measured, the driver has neither sub-devices nor a known variable\n");
    for (const Work& work : works) {
        const std::vector<std::string> models = models_of(results, work.name);
        if (models.empty())
            continue;
        fmt::print("\n{}: {}; million/s\n", work.name, work.what);
        fmt::print("{:<20} {:>7} {:>9} {:>6} {:>9} {:>6} {:>6} {:>7} {:>7} {:>9} {:>7}\n", "",
                   "scalar", "1 thread", "ratio", fmt::format("{} threads", all_threads), "ratio",
                   "GB/s", "memory", "exp,log", "binds", "spread");
        for (const std::string& model : models) {
            const auto row = [&](const std::string& name, int threads) {
                return find_result(results, name, work.name, model, threads);
            };
            const Result* const scalar = row(baseline, 1);
            const Result* const all = row(device.name, all_threads);
            print_line(report, model, scalar, row(device.name, 1), all_threads > 1 ? all : nullptr);
        }
        for (const char* native : {precomputed_baseline, simd_baseline})
            for (const std::string& model : models) {
                const Result *one = nullptr, *several = nullptr;
                for (const Result& result : results)
                    if (result.device == native && result.work == work.name &&
                        result.model == model)
                        (result.threads == 1 ? one : several) = &result;
                if (native == precomputed_baseline && model != "kurt")
                    continue; // the others are in the file that --json writes
                print_line(report,
                           model + (native == simd_baseline ? ", openmp simd" : ", precomputed"),
                           find_result(results, baseline, work.name, model, 1), one, several);
            }
    }
    bool first = true;
    for (const Result& result : results) {
        if (result.device != device.name || result.work != table_work)
            continue;
        if (first)
            fmt::print("\ntable: albedo of {0} cosines and {0} roughnesses to 1e-4, {1} threads; "
                       "seconds\n",
                       table_size, result.threads);
        first = false;
        fmt::print("{:<20} {:>9.2f} {:>6}\n", result.model,
                   static_cast<double>(table_size * table_size) / result.samples_per_second,
                   percent(result.spread));
    }
    for (const Result& result : results)
        for (const auto& [work, what] :
             {std::pair{rgl_work, "an RGL file at pairs of directions"},
              std::pair{render_work, "a metal sphere in a studio, samples that meet it"}})
            if (result.device == device.name && result.work == work)
                fmt::print("\n{}, {} thread{}: {} million/s, spread {}", what, result.threads,
                           result.threads == 1 ? "" : "s", millions(&result),
                           percent(result.spread));
    for (const Result& result : results)
        if (result.device == device.name && result.work == fit_work)
            fmt::print("\nfit of {} to a MERL file of {} bins, {} thread{}, process start to exit: "
                       "{:.3f} s, spread {}",
                       result.model, fitted_bins, result.threads, result.threads == 1 ? "" : "s",
                       fitted_bins / result.samples_per_second, percent(result.spread));
    const Result* const run = find_result(results, device.name, run_work, run_by_log, all_threads);
    const Result* const fits = find_result(results, device.name, run_work, run_by_fit, all_threads);
    if (run != nullptr && fits != nullptr)
        fmt::print("\nrun of {} fits to it, process start to exit: {:.1f} fits/s, spread {}, {:g} "
                   "evaluations a fit on all samples; fit, the same: {:.1f}, spread {}",
                   run_fits, run->samples_per_second, percent(run->spread), run->evaluations,
                   fits->samples_per_second, percent(fits->spread));
    for (const CompileTime& time : report.compile)
        if (time.device == device.name)
            fmt::print("\nkernels that a fit of {} needs: {:.2f} s to build, {:.3f} s from the "
                       "cache",
                       time.model, time.cold.median, time.warm.median);
    fmt::print("\n");
}

/// Reading files takes no device.
void print_reading(const std::vector<Result>& results) {
    bool first = true;
    for (const Result& result : results) {
        if (result.work != read_work)
            continue;
        if (first)
            fmt::print("\nread: whole files in memory; million samples/s, GB/s, spread\n");
        first = false;
        fmt::print("{:<20} {:>9} {:>6.2f} {:>6}\n", result.model, millions(&result),
                   result.samples_per_second * result.bytes_per_sample / 1e9,
                   percent(result.spread));
    }
}

} // namespace

const Result* find_result(const std::vector<Result>& results, const std::string& device,
                          const std::string& work, const std::string& model, int threads) {
    for (const Result& result : results)
        if (result.device == device && result.work == work && result.model == model &&
            result.threads == threads)
            return &result;
    return nullptr;
}

void check_answers(std::vector<Result>& results) {
    for (Result& result : results) {
        const Work* const work = find_work(result.work);
        if (work == nullptr)
            continue; // checked where it was measured
        const Result* const reference =
            find_result(results, baseline, result.work, result.model, 1);
        if (reference == nullptr)
            throw InputError(fmt::format("{} of {} on {}: no answer in float64 to compare with",
                                         result.work, result.model, result.device));
        result.difference = difference(result.answer, reference->answer);
        if (!(result.difference < work->tolerance))
            throw InputError(fmt::format("{} ({} threads), {} of {}: the answer differs from that "
                                         "of {} by {:.1e}; expected less than {:.0e}",
                                         result.device, result.threads, result.work, result.model,
                                         baseline, result.difference, work->tolerance));
    }
}

std::vector<Target> targets_of(const Report& report) {
    std::vector<Target> targets;
    const std::vector<Result>& results = report.measured.results;
    constexpr double enough_of_memory = 0.7;
    for (const Device& device : report.devices) {
        if (!device.cpu)
            continue;
        const int all = static_cast<int>(device.compute_units);
        const auto speed = [&](const std::string& name, const char* work, const std::string& model,
                               int threads) {
            const Result* const r = find_result(results, name, work, model, threads);
            return r == nullptr ? 0 : r->samples_per_second;
        };
        const auto add = [&](const std::string& name, double value, double of, double least,
                             Target::Instead instead = {}) {
            if (value > 0 && of > 0)
                targets.push_back({name, value / of, least, false, std::move(instead)});
        };
        // The share of the memory's bandwidth that does instead.
        const auto share = [&]() -> Target::Instead {
            const Result* const r =
                find_result(results, device.name, "error-gradient", "kurt", all);
            const Peaks* const peaks = peaks_of(report, device.name, all);
            if (r == nullptr || peaks == nullptr)
                return {};
            return {peaks->memory_share(*r), enough_of_memory, "of the bandwidth"};
        };
        add("kurt, error-gradient, 1 thread, times scalar float64",
            speed(device.name, "error-gradient", "kurt", 1),
            speed(baseline, "error-gradient", "kurt", 1), 25);
        std::string slowest;
        double least_ratio = 0;
        for (const std::string& model : models_of(results, "error-gradient")) {
            const double one = speed(device.name, "error-gradient", model, 1);
            const double scalar = speed(baseline, "error-gradient", model, 1);
            if (one > 0 && scalar > 0 && model != "lambert" &&
                (slowest.empty() || one / scalar < least_ratio)) {
                slowest = model;
                least_ratio = one / scalar;
            }
        }
        add(fmt::format("every model, the same; the least: {}", slowest), least_ratio, 1, 12);
        for (const Result& result : results)
            if (result.device == simd_baseline && result.work == "error-gradient" &&
                result.threads > 1)
                add("kurt, error-gradient, all threads, times g++ OpenMP SIMD",
                    speed(device.name, "error-gradient", "kurt", all), result.samples_per_second,
                    1.3, share());
        for (const int threads : {1, all})
            add(fmt::format(
                    "kurt, a candidate of a batch, {} thread{}, times an error-gradient pass",
                    threads, threads == 1 ? "" : "s"),
                speed(device.name, "search", "kurt", threads),
                speed(device.name, "error-gradient", "kurt", threads), 2.5);
        if (all == 4)
            add("kurt, error-gradient, 4 threads, times 1 thread",
                speed(device.name, "error-gradient", "kurt", 4),
                speed(device.name, "error-gradient", "kurt", 1), 3.2, share());
        const double fit = speed(device.name, fit_work, "kurt", all);
        if (fit > 0) {
            targets.push_back({fmt::format("whole kurt fit, {} threads, seconds", all),
                               fitted_bins / fit,
                               0.35,
                               true,
                               {}});
            const double scalar = speed(baseline, "error-gradient", "kurt", 1);
            if (scalar > 0)
                targets.push_back(
                    {"the same in passes of the scalar loop", scalar / fit, 4, true, {}});
        }
        for (const char* model : {"kurt", "ashikhmin-shirley"})
            add(fmt::format("{}, sample, 1 thread, million/s", model),
                speed(device.name, "sample", model, 1), 1e6, 50);
        slowest.clear();
        for (const std::string& model : models_of(results, "eval")) {
            const double one = speed(device.name, "eval", model, 1);
            if (one > 0 && (slowest.empty() || one < least_ratio)) {
                slowest = model;
                least_ratio = one;
            }
        }
        if (!slowest.empty())
            add(fmt::format("every model, eval, 1 thread, million/s; the least: {}", slowest),
                least_ratio, 1e6, 100);
    }
    return targets;
}

void print(const Report& report) {
    const NativeBuild build = native_build();
    fmt::print(
        "machine: {}\nnative: {}, {}; simd: {}\n"
        "{} samples of 3 channels on MERL's grid; medians of repeated runs, spread: distance "
        "of the quartiles\nratio: to {} on one thread; memory and exp,log: shares of what the "
        "device does at most\n",
        processor_name(), build.compiler, build.scalar_flags,
        build.simd_flags == nullptr ? "not built" : build.simd_flags, report.samples, baseline);
    for (const Device& device : report.devices)
        print_device(report, device);
    print_reading(report.measured.results);
    const std::vector<Target> targets = targets_of(report);
    if (targets.empty())
        return;
    fmt::print("\n| target | at least | measured | |\n|---|---|---|---|\n");
    for (const Target& target : targets)
        fmt::print(
            "| {} | {}{:g}{} | {:.2f}{} | {} |\n", target.name, target.at_most ? "at most " : "",
            target.least,
            target.instead.least > 0
                ? fmt::format(", or {} {}", percent(target.instead.least), target.instead.what)
                : "",
            target.value, target.instead.least > 0 ? ", " + percent(target.instead.value) : "",
            target.met() ? "met" : "missed");
}

nlohmann::ordered_json to_json(const Report& report) {
    const NativeBuild build = native_build();
    std::string names, drivers;
    nlohmann::ordered_json devices = nlohmann::ordered_json::array();
    for (const Device& device : report.devices) {
        names += (names.empty() ? "" : ", ") + device.name;
        drivers += (drivers.empty() ? "" : ", ") + device.driver;
        devices.push_back({{"name", device.name},
                           {"platform", device.platform},
                           {"driver", device.driver},
                           {"compute_units", device.compute_units},
                           {"form", to_json(device.form)}});
    }
    nlohmann::ordered_json json = {{"device", names},
                                   {"driver", drivers},
                                   {"version", version},
                                   {"kernels", kernel_hash()},
                                   {"machine", processor_name()},
                                   {"devices", devices},
                                   {"compiler", build.compiler},
                                   {"native_flags", build.scalar_flags},
                                   {"simd_flags", nullptr},
                                   {"samples", report.samples},
                                   {"results", nlohmann::ordered_json::array()},
                                   {"peaks", nlohmann::ordered_json::array()},
                                   {"compile", nlohmann::ordered_json::array()},
                                   {"targets", nlohmann::ordered_json::array()}};
    if (build.simd_flags != nullptr)
        json["simd_flags"] = build.simd_flags;
    for (const Result& result : report.measured.results)
        json["results"].push_back(to_json(result, peaks_of(report, result.device, result.threads)));
    for (const Peaks& peaks : report.measured.peaks)
        json["peaks"].push_back(to_json(peaks));
    for (const CompileTime& time : report.compile)
        json["compile"].push_back({{"device", time.device},
                                   {"model", time.model},
                                   {"cold_seconds", time.cold.median},
                                   {"warm_seconds", time.warm.median},
                                   {"warm_spread", time.warm.spread}});
    for (const Target& target : targets_of(report))
        json["targets"].push_back({{"name", target.name},
                                   {"value", target.value},
                                   {target.at_most ? "most" : "least", target.least},
                                   {"met", target.met()}});
    return json;
}

} // namespace brdfit::bench

#include "bench/whole.hpp"

#include "bench/again.hpp"
#include "bench/native_tasks.hpp"
#include "bench/opencl.hpp"
#include "bench/scratch.hpp"
#include "fit/objective.hpp"
#include "fit/programs.hpp"
#include "fit/runs/log.hpp"
#include "host/error.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/measured/merl.hpp"

#include <cmath>
#include <fmt/format.h>
#include <sched.h>

namespace brdfit::bench {

namespace {

constexpr double fit_tolerance = 1e-3; // of the error, float32 against float64
constexpr double max_theta = 80;       // degrees, what fits keep by default

// This thread, and processes started meanwhile, on one processor.
class OnOneProcessor {
  public:
    OnOneProcessor() {
        if (sched_getaffinity(0, sizeof before_, &before_) != 0)
            return;
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
            if (CPU_ISSET(cpu, &before_))
                CPU_SET(cpu, &one);
        changed_ = sched_setaffinity(0, sizeof one, &one) == 0;
    }
    ~OnOneProcessor() {
        if (changed_)
            sched_setaffinity(0, sizeof before_, &before_);
    }
    OnOneProcessor(const OnOneProcessor&) = delete;
    OnOneProcessor& operator=(const OnOneProcessor&) = delete;

  private:
    cpu_set_t before_{};
    bool changed_ = false;
};

Result fit_result(const Device& device, int threads, const Timing& timing) {
    Result result;
    result.device = device.name;
    result.work = fit_work;
    result.model = "kurt";
    result.threads = threads;
    result.samples_per_second = fitted_bins / timing.median;
    result.spread = timing.spread;
    return result;
}

// Relative difference of the file's error from float64's at its parameters.
double error_difference(const Samples& data, const std::string& path) {
    const Material fitted = read_material(path);
    Samples near = data;
    const double lowest = std::cos(max_theta * degree);
    for (std::size_t k = 0; k < near.count(); ++k)
        if (near.directions->plane(Directions::WiZ)[k] < lowest ||
            near.directions->plane(Directions::WoZ)[k] < lowest)
            near.valid[k] = 0;
    const std::vector<ScalarSample> samples = scalar_samples(near);
    const Problem problem = problems({"kurt"}).front();
    const ScalarModel& model = *ScalarModel::find(problem.structure);
    const std::vector<double>& theta = fitted.lobes.at(0).theta;
    const Answer error =
        solved(model, model.sums(samples, theta.data(), 3, Sums::Basis), 3, false, samples.size());
    const double reported = fitted.fit.at("error").at("ngan");
    return difference({reported}, {std::sqrt(error[0])});
}

} // namespace

std::vector<Result> measure_fit(const Device& device, const Samples& data) {
    const Scratch folder;
    const std::string file = folder / "bench.binary", out = folder / "out";
    merl::write(data, file);
    const std::vector<std::string> fit = {
        "--device", std::to_string(device.index), "--quiet", "fit", file, "-m", "kurt", "-o", out,
        "--force"};
    const Repeats repeats{1, 5, 5, 0};
    std::vector<Result> results;
    const auto timed = [&](int threads,
                           const std::vector<std::pair<std::string, std::string>>& variables) {
        results.push_back(
            fit_result(device, threads, time_runs([&] { run_again(fit, variables); }, repeats)));
    };
    const int all = static_cast<int>(device.compute_units);
    timed(all, {});
    const double off = error_difference(data, out + "/bench.kurt.1.json");
    if (!(off < fit_tolerance))
        throw InputError(fmt::format("{}: the fit's error differs from that of {} by {:.1e}; "
                                     "expected less than {:.0e}",
                                     device.name, baseline, off, fit_tolerance));
    results.back().difference = off;
    if (const auto variables = one_thread_environment(device); !variables.empty() && all > 1) {
        const OnOneProcessor limited;
        timed(1, variables);
        results.back().difference = off;
    }
    return results;
}

std::vector<Result> measure_run(const Device& device, const Samples& data) {
    const Scratch folder;
    const std::string file = folder / "bench.binary";
    merl::write(data, file);
    const auto here = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"--device", std::to_string(device.index), "--quiet"});
        run_again(arguments, {});
    };
    const std::vector<std::string> fits = {file, "-m", run_models, "--lobes", "1,2"};
    const auto with = [&](const char* name, const std::string& out) {
        std::vector<std::string> arguments{name};
        arguments.insert(arguments.end(), fits.begin(), fits.end());
        arguments.insert(arguments.end(), {"-o", out, "--force"});
        return arguments;
    };
    constexpr Repeats repeats{1, 5, 5, 0};
    // A plan is made once: each run has a folder of its own.
    std::vector<std::string> plans;
    for (std::size_t i = 0; i < repeats.most + static_cast<std::size_t>(repeats.warm_ups); ++i) {
        plans.push_back(folder / fmt::format("run{}", i));
        run_again(with("plan", plans.back()), {});
    }
    const auto row = [&](const char* name, const Timing& timing) {
        Result result;
        result.device = device.name;
        result.work = run_work;
        result.model = name;
        result.threads = static_cast<int>(device.compute_units);
        result.samples_per_second = run_fits / timing.median;
        result.spread = timing.spread;
        return result;
    };
    std::size_t next = 0;
    std::vector<Result> results{row(run_by_log, time_runs(
                                                    [&] {
                                                        here({"run", plans[next++]});
                                                    },
                                                    repeats))};
    std::vector<double> evaluations;
    const RunLogs logs = read_logs(plans.front());
    for (const ShardLog& log : logs.logs)
        for (const LoggedRow& logged : log.rows)
            evaluations.push_back(log.read(logged).at("material").at("fit").at("evaluations"));
    if (evaluations.size() != static_cast<std::size_t>(run_fits))
        throw InputError(fmt::format("{}: a run made {} fits; expected {}", device.name,
                                     evaluations.size(), run_fits));
    results.back().evaluations = timing_of(evaluations).median;
    results.push_back(
        row(run_by_fit, time_runs([&] { here(with("fit", folder / "fits")); }, repeats)));
    return results;
}

double build_and_run_kernels(const Device& device) {
    const Problem problem = problems({"kurt"}).front();
    Samples data = synthesise(device, problem.material(), random_directions(512, true, 1), 0.02, 1);
    const auto started = std::chrono::steady_clock::now();
    const DeviceSamples packed = pack_samples(device, data, 90, Metric::Ngan);
    ProgramCache cache(device);
    Objective objective(device, cache.get(problem.structure, packed.channels, packed.chunk),
                        packed);
    std::vector<double> gradient;
    objective.shape_sums({problem.theta});
    objective.projected_error(problem.theta);
    objective.projected_error(problem.theta, &gradient);
    objective.normal_sums(problem.theta, objective.coefficients());
    objective.metric_errors(problem.theta, objective.coefficients());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
}

CompileTime measure_compile(const Device& device) {
    const Scratch folder;
    const auto seconds = [&] {
        const std::string text =
            run_again({"--device", std::to_string(device.index), "bench", "--child", "compile"},
                      {{"BRDFIT_CACHE", folder / "brdfit"},
                       {"POCL_CACHE_DIR", folder / "cache"},
                       {"MESA_SHADER_CACHE_DIR", folder / "mesa"},
                       {"CUDA_CACHE_PATH", folder / "cuda"}});
        return std::stod(text);
    };
    CompileTime time{device.name, "kurt", timing_of({seconds()}), {}};
    time.warm = timing_of({seconds(), seconds(), seconds()});
    return time;
}

} // namespace brdfit::bench

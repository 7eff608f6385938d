#pragma once

#include "bench/native/calls.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace brdfit::bench {

/// A kind of work that is measured for every model. Adding one: an entry here, and what does it in
/// device_tasks() and, where float64 can tell the answer, scalar_tasks().
struct Work {
    const char* name;
    const char* what; ///< for people
    double tolerance; ///< an answer further than this from float64's is wrong
};
inline constexpr Work works[] = {
    {"eval", "f of three channels at pairs of directions in the device's memory, stored there",
     1e-4},
    {"error", "a fit's error at given shapes, with the best kd and ks", 1e-4},
    {"sums", "all sums of a Gauss-Newton step, for given shapes, kd and ks; some cancel", 1e-3},
    {"error-gradient", "error and its derivatives by the shapes, one evaluation of a fit", 1e-4},
    {"search", "the sums of a batch of candidates; samples count once for each candidate", 1e-4},
    {"sample", "a light direction with density and weights, drawn for a viewer at 45 degrees",
     2e-3},
};
/// The work of that name, or nullptr.
const Work* find_work(const std::string& name);

/// What a run computed, as numbers that depend on every sample.
using Answer = std::vector<double>;
/// The largest relative difference, of values below a hundredth of the first as a share of that
/// hundredth; infinite for a NaN and for answers of different lengths.
double difference(const Answer& a, const Answer& reference);

/// Seconds of repeated runs: the median, the distance of the quartiles as a fraction of it, and the
/// least.
struct Timing {
    double median, spread, best;
};
Timing timing_of(std::vector<double> seconds);

/// How often runs are repeated: at least `fewest` times and for `seconds`, after `warm_ups` runs
/// that do not count (they compile kernels and find a solution to sum about).
struct Repeats {
    int warm_ups = 2;
    std::size_t fewest = 5, most = 60;
    double seconds = 0.12;
};
Timing time_runs(const std::function<void()>& body, const Repeats& repeats = {});

/// Something that can be run again and again.
struct Task {
    std::string work, model;
    std::function<void()> run;
    std::function<Answer()> answer; ///< of the last run; null where nothing is compared
    double samples = 0;             ///< a run handles
    double bytes_per_sample = 0;    ///< read and written
    double working_set = 0;         ///< bytes that a run goes through
    Calls calls = {};
};

/// A row of the results.
struct Result {
    std::string device, work, model;
    int threads = 1; ///< of the processor; compute units of a GPU
    double samples_per_second = 0;
    double spread = 0; ///< distance of the quartiles of the runs, as a fraction of their median
    double bytes_per_sample = 0, working_set = 0;
    Calls calls;
    Answer answer;
    double difference = 0;  ///< of the answer from float64's
    double evaluations = 0; ///< on all samples, the median of the fits made; 0: none were
};
Result measure(const Task& task, const std::string& device, int threads,
               const Repeats& repeats = {});

/// What a device does at most, measured by kernels that do nothing else.
struct Peaks {
    std::string device;
    int threads = 1;
    double exp_per_second = 0, log_per_second = 0;
    /// Reading memory: bytes a second of buffers of so many bytes, caches included; ascending.
    struct Reading {
        double bytes, bytes_per_second;
    };
    std::vector<Reading> reading;
    /// For a working set of so many bytes.
    double bytes_per_second(double bytes) const;
    /// Shares of these that a result takes.
    double memory_share(const Result& result) const;
    double calls_share(const Result& result) const;
    /// "memory", "exp, log" or "other" (arithmetic): what takes most of the time.
    const char* binds(const Result& result) const;
};

/// How long programs take to build: from nothing, and with the driver's cache of binaries.
struct CompileTime {
    std::string device, model;
    Timing cold, warm;
};

/// A row without its answer, as in the file that --json writes; `peaks` may be null.
nlohmann::ordered_json to_json(const Result& result, const Peaks* peaks);
nlohmann::ordered_json to_json(const Peaks& peaks);
/// Rows and peaks with answers, for the run that started this one; and back. Throws nlohmann's
/// exceptions for anything else.
struct Measured {
    std::vector<Result> results;
    std::vector<Peaks> peaks;
};
nlohmann::ordered_json to_message(const Measured& measured);
Measured measured_from_message(const nlohmann::ordered_json& json);

/// The processor's name, "unknown" where the system does not say.
std::string processor_name();

} // namespace brdfit::bench

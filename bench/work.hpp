#pragma once

#include "host/device/program.hpp"
#include "host/measured/samples.hpp"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace brdfit::bench {

/// Data to measure on and a model to measure: a material, synthesised with noise on MERL's grid and
/// then evaluated at another theta, where neither error nor gradient vanishes.
struct Problem {
    std::string material; ///< text of a material file
    std::vector<double> theta;
};
/// The models measured. Adding one is adding an entry; answers are checked, and ratios given, where
/// native.hpp knows the model.
const std::vector<Problem>& problems();

/// One evaluation as a fit does it: the mean squared error at theta with the best non-negative kd
/// and ks, and its gradient by theta where asked for.
struct Work {
    const char* name;
    bool gradient;
};
inline constexpr Work works[] = {{"error", false}, {"error-gradient", true}};

struct Answer {
    double error = 0; ///< mean squared error, metric ngan
    std::vector<double> gradient;
};
/// The largest relative difference of the error and of each derivative; a NaN is infinitely far.
double difference(const Answer& a, const Answer& reference);

/// Seconds of repeated runs: the median, and the distance of the quartiles as a fraction of it.
struct Timing {
    double median, spread;
};
Timing timing_of(std::vector<double> seconds);

/// Times `body` after a warm-up, which also compiles kernels and finds a solution to sum about.
template <typename Body>
Timing time_runs(Body body) {
    constexpr std::size_t fewest = 7, most = 200;
    constexpr double enough = 0.6;
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    };
    for (int warm_up = 0; warm_up < 3; ++warm_up)
        body();
    std::vector<double> seconds;
    const auto begin = Clock::now();
    while (seconds.size() < fewest || (seconds.size() < most && since(begin) < enough)) {
        const auto start = Clock::now();
        body();
        seconds.push_back(since(start));
    }
    return timing_of(std::move(seconds));
}

/// A row of the table.
struct Result {
    std::string device, work, model;
    int threads = 1; ///< of the processor; compute units of a GPU
    double samples_per_second = 0;
    double spread = 0; ///< distance of the quartiles of the runs, as a fraction of their median
    double bytes_per_sample = 0;
    Answer answer;
    double difference = 0; ///< of the answer from the baseline's
};
nlohmann::ordered_json to_json(const Result& result, bool with_answer);
/// What to_json wrote with the answer. Throws nlohmann's exceptions for anything else.
Result result_from_json(const nlohmann::ordered_json& json);

Structure structure_of(const Material& material);
/// The problem's noisy samples; valid are those above the horizon, or about `most` of them, evenly
/// spaced, where `most` is not 0.
Samples samples_of(const Device& device, const Problem& problem, std::size_t most);

/// Hash of the sources of all kernels, those used while developing included.
std::string kernel_hash();
/// The processor's name, "unknown" where the system does not say.
std::string processor_name();

} // namespace brdfit::bench

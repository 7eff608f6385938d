#include "bench/work.hpp"

#include <cmath>
#include <fstream>
#include <limits>

namespace brdfit::bench {

namespace {

// Linear between the two values around the place that `share` of the sorted values lie below.
double quantile(const std::vector<double>& sorted, double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double relative_difference(double a, double reference, double least) {
    if (a == reference)
        return 0;
    const double difference = std::abs(a - reference) / std::max(std::abs(reference), least);
    return std::isfinite(difference) ? difference : std::numeric_limits<double>::infinity();
}

} // namespace

const Work* find_work(const std::string& name) {
    for (const Work& work : works)
        if (name == work.name)
            return &work;
    return nullptr;
}

double difference(const Answer& a, const Answer& reference) {
    if (a.size() != reference.size())
        return std::numeric_limits<double>::infinity();
    constexpr double least_share = 0.01; // of the first value: what is smaller has cancelled
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(
            largest, relative_difference(a[i], reference[i], least_share * std::abs(reference[0])));
    return largest;
}

Timing timing_of(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    const double median = quantile(seconds, 0.5);
    return {median, (quantile(seconds, 0.75) - quantile(seconds, 0.25)) / median, seconds.front()};
}

Timing time_runs(const std::function<void()>& body, const Repeats& repeats) {
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    };
    for (int warm_up = 0; warm_up < repeats.warm_ups; ++warm_up)
        body();
    std::vector<double> seconds;
    const auto begin = Clock::now();
    while (seconds.size() < repeats.fewest ||
           (seconds.size() < repeats.most && since(begin) < repeats.seconds)) {
        const auto start = Clock::now();
        body();
        seconds.push_back(since(start));
    }
    return timing_of(std::move(seconds));
}

Result measure(const Task& task, const std::string& device, int threads, const Repeats& repeats) {
    const Timing timing = time_runs(task.run, repeats);
    Result result;
    result.device = device;
    result.work = task.work;
    result.model = task.model;
    result.threads = threads;
    result.samples_per_second = task.samples / timing.median;
    result.spread = timing.spread;
    result.bytes_per_sample = task.bytes_per_sample;
    result.working_set = task.working_set;
    result.calls = task.calls;
    if (task.answer)
        result.answer = task.answer();
    return result;
}

double Peaks::bytes_per_second(double bytes) const {
    // Linear in the logarithm of the size.
    for (std::size_t i = 1; i < reading.size(); ++i)
        if (bytes < reading[i].bytes) {
            const Reading &a = reading[i - 1], &b = reading[i];
            const double share =
                std::clamp(std::log(bytes / a.bytes) / std::log(b.bytes / a.bytes), 0.0, 1.0);
            return a.bytes_per_second + share * (b.bytes_per_second - a.bytes_per_second);
        }
    return reading.back().bytes_per_second;
}

double Peaks::memory_share(const Result& result) const {
    return result.samples_per_second * result.bytes_per_sample /
           bytes_per_second(result.working_set);
}

double Peaks::calls_share(const Result& result) const {
    return result.samples_per_second *
           (result.calls.exp / exp_per_second + result.calls.log / log_per_second);
}

const char* Peaks::binds(const Result& result) const {
    constexpr double most_of_it = 0.5;
    const double memory = memory_share(result), calls = calls_share(result);
    if (std::max(memory, calls) < most_of_it)
        return "other";
    return memory >= calls ? "memory" : "exp, log";
}

nlohmann::ordered_json to_json(const Result& result, const Peaks* peaks) {
    nlohmann::ordered_json json = {{"device", result.device},
                                   {"work", result.work},
                                   {"model", result.model},
                                   {"threads", result.threads},
                                   {"samples_per_second", result.samples_per_second},
                                   {"spread", result.spread},
                                   {"difference", result.difference}};
    if (result.evaluations > 0)
        json["evaluations"] = result.evaluations;
    if (result.bytes_per_sample > 0) {
        json["bytes_per_sample"] = result.bytes_per_sample;
        json["gigabytes_per_second"] = result.samples_per_second * result.bytes_per_sample / 1e9;
    }
    if (peaks != nullptr) {
        json["exp_per_sample"] = result.calls.exp;
        json["log_per_sample"] = result.calls.log;
        json["memory_share"] = peaks->memory_share(result);
        json["exp_log_share"] = peaks->calls_share(result);
        json["binds"] = peaks->binds(result);
    }
    return json;
}

nlohmann::ordered_json to_json(const Peaks& peaks) {
    nlohmann::ordered_json reading = nlohmann::ordered_json::array();
    for (const Peaks::Reading& r : peaks.reading)
        reading.push_back({{"bytes", r.bytes}, {"bytes_per_second", r.bytes_per_second}});
    return {{"device", peaks.device},
            {"threads", peaks.threads},
            {"exp_per_second", peaks.exp_per_second},
            {"log_per_second", peaks.log_per_second},
            {"reading", reading}};
}

nlohmann::ordered_json to_message(const Measured& measured) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array(),
                           peaks = nlohmann::ordered_json::array();
    for (const Result& r : measured.results)
        rows.push_back({r.device, r.work, r.model, r.threads, r.samples_per_second, r.spread,
                        r.bytes_per_sample, r.working_set, r.calls.exp, r.calls.log, r.answer});
    for (const Peaks& p : measured.peaks)
        peaks.push_back(to_json(p));
    return {{"rows", rows}, {"peaks", peaks}};
}

Measured measured_from_message(const nlohmann::ordered_json& json) {
    Measured measured;
    for (const auto& row : json.at("rows")) {
        Result r;
        r.device = row.at(0);
        r.work = row.at(1);
        r.model = row.at(2);
        r.threads = row.at(3);
        r.samples_per_second = row.at(4);
        r.spread = row.at(5);
        r.bytes_per_sample = row.at(6);
        r.working_set = row.at(7);
        r.calls = {row.at(8), row.at(9)};
        r.answer = row.at(10).get<Answer>();
        measured.results.push_back(std::move(r));
    }
    for (const auto& p : json.at("peaks")) {
        Peaks peaks{
            p.at("device"), p.at("threads"), p.at("exp_per_second"), p.at("log_per_second"), {}};
        for (const auto& r : p.at("reading"))
            peaks.reading.push_back({r.at("bytes"), r.at("bytes_per_second")});
        measured.peaks.push_back(std::move(peaks));
    }
    return measured;
}

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

} // namespace brdfit::bench

#include "bench/work.hpp"

#include "host/embedded.hpp"
#include "host/file.hpp"
#include "host/model/synthesise.hpp"

#include <cmath>
#include <fstream>
#include <limits>

namespace brdfit::bench {

namespace {

constexpr double noise = 0.02;
constexpr std::uint64_t seed = 1;

// Linear between the two values around the place that `share` of the sorted values lie below.
double quantile(const std::vector<double>& sorted, double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double relative_difference(double a, double reference) {
    if (a == reference)
        return 0;
    const double difference = std::abs(a - reference) / std::abs(reference);
    return std::isfinite(difference) ? difference : std::numeric_limits<double>::infinity();
}

} // namespace

const std::vector<Problem>& problems() {
    static const std::vector<Problem> all = {
        {R"({"brdfit": 1, "channels": ["R", "G", "B"],
             "diffuse": {"model": "lambert", "kd": [0.2, 0.1, 0.05]},
             "lobes": [{"model": "kurt", "ks": [0.3, 0.4, 0.5], "f0": 0.2, "m": 0.2,
                        "alpha": 0.2}]})",
         {0.3, 0.25, 0.35}},
    };
    return all;
}

double difference(const Answer& a, const Answer& reference) {
    if (a.gradient.size() != reference.gradient.size())
        return std::numeric_limits<double>::infinity();
    double largest = relative_difference(a.error, reference.error);
    for (std::size_t i = 0; i < a.gradient.size(); ++i)
        largest = std::max(largest, relative_difference(a.gradient[i], reference.gradient[i]));
    return largest;
}

Timing timing_of(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    const double median = quantile(seconds, 0.5);
    return {median, (quantile(seconds, 0.75) - quantile(seconds, 0.25)) / median};
}

nlohmann::ordered_json to_json(const Result& result, bool with_answer) {
    nlohmann::ordered_json json = {{"device", result.device},
                                   {"work", result.work},
                                   {"model", result.model},
                                   {"threads", result.threads},
                                   {"samples_per_second", result.samples_per_second},
                                   {"spread", result.spread},
                                   {"bytes_per_sample", result.bytes_per_sample},
                                   {"difference", result.difference}};
    if (with_answer)
        json["answer"] = {{"error", result.answer.error}, {"gradient", result.answer.gradient}};
    return json;
}

Result result_from_json(const nlohmann::ordered_json& json) {
    Result result;
    result.device = json.at("device");
    result.work = json.at("work");
    result.model = json.at("model");
    result.threads = json.at("threads");
    result.samples_per_second = json.at("samples_per_second");
    result.spread = json.at("spread");
    result.bytes_per_sample = json.at("bytes_per_sample");
    result.answer.error = json.at("answer").at("error");
    result.answer.gradient = json.at("answer").at("gradient").get<std::vector<double>>();
    return result;
}

Structure structure_of(const Material& material) {
    Structure structure;
    structure.diffuse = material.diffuse;
    structure.isotropic = material.isotropic();
    for (const Lobe& lobe : material.lobes)
        structure.lobes.push_back(lobe.model);
    return structure;
}

Samples samples_of(const Device& device, const Problem& problem, std::size_t most) {
    const char* const source = "the benchmark's material";
    Samples samples =
        synthesise_merl(device, parse_material(problem.material, source), noise, seed, source);
    samples.source = source;
    const std::size_t valid = samples.valid_count();
    const std::size_t step = most == 0 ? 1 : std::max<std::size_t>(valid / most, 1);
    for (std::size_t k = 0, n = 0; k < samples.count(); ++k)
        if (samples.valid[k] != 0 && n++ % step != 0)
            samples.valid[k] = 0;
    return samples;
}

std::string kernel_hash() {
    std::string text;
    for (const EmbeddedFile* file = embedded_kernels; file->name != nullptr; ++file)
        text += std::string(file->name) + '\n' + kernel_source(file->name) + '\n';
    return sha256(text);
}

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

} // namespace brdfit::bench

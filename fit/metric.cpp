#include "fit/metric.hpp"

#include "host/error.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

constexpr const char* metric_names[metric_count] = {"ngan", "l2", "log", "cbrt"};

/// cbrt, below 1e-6 the odd cubic that meets it smoothly.
double smooth_cbrt(double x) {
    constexpr double epsilon = 1e-6;
    const double u = x / epsilon;
    return std::abs(u) < 1 ? u * (4 - u * u) * (0.01 / 3) : std::cbrt(x);
}

double compressed_log(double x) {
    return std::log1p(std::max(x, 0.0));
}

} // namespace

const char* name_of(Metric metric) {
    return metric_names[static_cast<int>(metric)];
}

Metric metric_named(const std::string& name) {
    for (int i = 0; i < metric_count; ++i)
        if (name == metric_names[i])
            return static_cast<Metric>(i);
    throw UsageError(fmt::format("unknown metric '{}'; known: ngan, l2, log, cbrt", name));
}

MetricErrors value_errors(const Samples& samples, const std::vector<std::uint32_t>& used,
                          const std::vector<float>& values) {
    MetricErrors sums{};
    const float* const wi_z = samples.directions->plane(Directions::WiZ);
    double whole = 0;
    for (const std::uint32_t k : used) {
        const double w = samples.weights.empty() ? 1 : double{samples.weights[k]};
        whole += w;
        for (std::size_t ch = 0; ch < samples.channels.size(); ++ch) {
            const double y = double{wi_z[k]} * samples.channel(ch)[k];
            const double f = double{wi_z[k]} * values[ch * samples.count() + k];
            const double of_log = compressed_log(f) - compressed_log(y);
            const double of_cbrt = smooth_cbrt(f) - smooth_cbrt(y);
            sums[0] += w * (f - y) * (f - y);
            sums[1] += (f - y) * (f - y);
            sums[2] += w * of_log * of_log;
            sums[3] += w * of_cbrt * of_cbrt;
        }
    }
    const auto channels = static_cast<double>(samples.channels.size());
    for (std::size_t m = 0; m < sums.size(); ++m)
        sums[m] =
            std::sqrt(sums[m] / channels / (m == 1 ? static_cast<double>(used.size()) : whole));
    return sums;
}

double error_outside_peak(const Samples& samples, const std::vector<std::uint32_t>& used,
                          const std::vector<float>& values) {
    const float* const hz = samples.directions->plane(Directions::HZ);
    std::vector<std::uint32_t> outside;
    for (const std::uint32_t k : used)
        if (hz[k] < std::cos(peak_theta * degree))
            outside.push_back(k);
    return outside.empty() ? std::numeric_limits<double>::quiet_NaN()
                           : value_errors(samples, outside, values)[0];
}

} // namespace brdfit

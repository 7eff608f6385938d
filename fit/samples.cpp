#include "fit/samples.hpp"

#include "host/device/buffer.hpp"
#include "host/error.hpp"
#include "kernels/passes/prepare.h"

#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

// Channels a pass handles at once: more would need more accumulators than a device has registers.
constexpr int largest_chunk = 8;

// Copies what of the samples `used` depends on the metric, not on the models, to the device.
void upload_used(const Device& device, const Samples& samples, Metric metric,
                 DeviceSamples& packed) {
    const std::vector<std::uint32_t>& used = packed.used;
    const std::size_t block = static_cast<std::size_t>(device.form.block);
    packed.count = used.size();
    packed.groups = (packed.count + block - 1) / block;
    packed.stride = packed.groups * block;
    packed.channels = static_cast<int>(samples.channels.size());
    packed.chunk = std::min(packed.channels, largest_chunk);
    packed.chunks = (packed.channels + packed.chunk - 1) / packed.chunk;
    packed.isotropic = samples.isotropic;
    packed.pairs = samples.count();

    const Directions& directions = *samples.directions;
    const bool weighted = !samples.weights.empty();
    double weight_sum = 0;
    for (const std::uint32_t k : used)
        weight_sum += weighted ? samples.weights[k] : 1.0F;
    if (!(weight_sum > 0))
        throw InputError(fmt::format("{}: the weights of the samples used add up to {}; expected "
                                     "a positive sum",
                                     samples.source, weight_sum));
    const double scale = static_cast<double>(packed.count) / weight_sum;

    std::vector<std::uint32_t> index(used);
    index.resize(packed.stride, used.back());
    packed.index = upload(device, index);
    std::vector<float> values(packed.stride *
                              static_cast<std::size_t>(packed.chunk * packed.chunks));
    // Vectors in the order of VALUE_AT of kernels/passes/prepare.cl.
    const bool together = device.form.local_size == 1;
    const auto width = static_cast<std::size_t>(device.form.vector_width);
    const auto chunk = static_cast<std::size_t>(packed.chunk);
    const std::size_t vectors = packed.stride / width; // a channel
    for (std::size_t ch = 0; ch < samples.channels.size(); ++ch) {
        const float* const from = samples.channel(ch);
        for (std::size_t k = 0; k < used.size(); ++k) {
            const std::size_t i = k / width;
            const std::size_t at =
                together ? VALUE_IN_CHUNK(vectors, i, ch, chunk) : VALUE_IN_PLANE(vectors, i, ch);
            values[at * width + k % width] = from[used[k]];
        }
    }
    packed.values = upload(device, values);
    std::vector<float> solid_angle(packed.stride), iz(packed.stride);
    const float* const wi_z = directions.plane(Directions::WiZ);
    for (std::size_t k = 0; k < used.size(); ++k) {
        solid_angle[k] = static_cast<float>(weighted ? samples.weights[used[k]] * scale : 1);
        iz[k] = wi_z[used[k]];
    }
    std::vector<float> weights = quadratic_weights(samples, used, solid_angle, metric);
    weights.resize(packed.stride, 0.0F);
    packed.weights = upload(device, weights);
    packed.solid_angle = upload(device, solid_angle);
    packed.iz = upload(device, iz);
}

} // namespace

std::vector<float> quadratic_weights(const Samples& samples, const std::vector<std::uint32_t>& used,
                                     const std::vector<float>& solid_angle, Metric metric) {
    const float* const wi_z = samples.directions->plane(Directions::WiZ);
    const std::size_t channels = samples.channels.size();
    // phi' grows without bound towards 0: below this share of the mean it is taken as it is there.
    double mean = 0;
    for (std::size_t ch = 0; ch < channels; ++ch)
        for (const std::uint32_t k : used)
            mean += std::abs(samples.channel(ch)[k]) * wi_z[k];
    mean /= static_cast<double>(used.size() * channels);
    const double floor = std::max(0.02 * mean, 1e-6);
    std::vector<float> weights(used.size());
    for (std::size_t i = 0; i < used.size(); ++i) {
        const double iz = wi_z[used[i]];
        double slopes = quadratic(metric) ? 1 : 0;
        for (std::size_t ch = 0; ch < channels && !quadratic(metric); ++ch) {
            const double x = std::max(iz * samples.channel(ch)[used[i]], floor);
            const double slope = metric == Metric::Log ? 1 / (1 + x) : std::cbrt(x) / (3 * x);
            slopes += slope * slope / static_cast<double>(channels);
        }
        weights[i] =
            static_cast<float>((metric == Metric::L2 ? 1 : solid_angle[i]) * iz * iz * slopes);
    }
    return weights;
}

std::vector<std::uint32_t> used_samples(const Samples& samples, double max_theta_degrees) {
    const double lowest_cosine = std::cos(max_theta_degrees * degree);
    const float* const iz = samples.directions->plane(Directions::WiZ);
    const float* const oz = samples.directions->plane(Directions::WoZ);
    std::vector<std::uint32_t> used;
    for (std::size_t k = 0; k < samples.count(); ++k)
        if (samples.valid[k] != 0 && iz[k] > 0 && oz[k] > 0 && iz[k] >= lowest_cosine &&
            oz[k] >= lowest_cosine)
            used.push_back(static_cast<std::uint32_t>(k));
    if (used.empty())
        throw InputError(
            fmt::format("{}: none of its {} samples is valid with both directions within {} "
                        "degrees of the normal; expected some",
                        samples.source, samples.count(), max_theta_degrees));
    return used;
}

DeviceSamples pack_samples(const Device& device, const Samples& samples, double max_theta_degrees,
                           Metric metric) {
    DeviceSamples packed;
    packed.used = used_samples(samples, max_theta_degrees);
    const Directions& directions = *samples.directions;
    // The packed copies are for this file only, the directions are read where they are.
    packed.directions = make_buffer(
        device, directions.data().size() * sizeof(float),
        static_cast<cl_mem_flags>(CL_MEM_READ_ONLY |
                                  (device.cpu ? CL_MEM_USE_HOST_PTR : CL_MEM_COPY_HOST_PTR)),
        const_cast<float*>(directions.data().data()));
    upload_used(device, samples, metric, packed);
    return packed;
}

DeviceSamples thin_samples(const Device& device, const Samples& samples,
                           const DeviceSamples& packed, Metric metric, std::size_t count) {
    if (count >= packed.count)
        return packed;
    DeviceSamples thin;
    thin.directions = packed.directions;
    const double run = static_cast<double>(packed.count) / static_cast<double>(count);
    std::uint32_t state = 1;
    for (std::size_t i = 0; i < count; ++i) {
        // A jittered place in each run: a regular stride would follow the grid's own period.
        state = state * 1664525U + 1013904223U;
        const double place = (static_cast<double>(i) + state / 4294967296.0) * run;
        thin.used.push_back(
            packed.used[std::min(static_cast<std::size_t>(place), packed.count - 1)]);
    }
    upload_used(device, samples, metric, thin);
    return thin;
}

} // namespace brdfit

#include "fit/samples.hpp"

#include "host/device/buffer.hpp"
#include "host/error.hpp"
#include "host/parallel.hpp"
#include "kernels/passes/prepare.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

// Channels a pass handles at once: more would need more accumulators than a device has registers.
constexpr int largest_chunk = 8;

// Samples that one thread packs at once.
constexpr std::size_t piece = 1 << 14;

// A buffer of `count` values that `fill(values)` writes where the device has them.
template <typename T, typename Fill>
cl::Buffer filled(const Device& device, std::size_t count, Fill fill) {
    cl::Buffer buffer = make_buffer(device, count * sizeof(T), CL_MEM_READ_ONLY);
    auto* const values = static_cast<T*>(device.queue.enqueueMapBuffer(
        buffer, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, count * sizeof(T)));
    fill(values);
    device.queue.enqueueUnmapMemObject(buffer, values);
    device.queue.finish(); // other queues read it
    return buffer;
}

// Where the metric is not quadratic: phi' grows without bound towards 0, below this share of the
// mean it is taken as it is there.
double lowest_slope_at(const Samples& samples, const std::vector<std::uint32_t>& used) {
    const float* const wi_z = samples.directions->plane(Directions::WiZ);
    const std::size_t channels = samples.channels.size();
    double mean = 0;
    for (std::size_t ch = 0; ch < channels; ++ch)
        for (const std::uint32_t k : used)
            mean += std::abs(samples.channel(ch)[k]) * wi_z[k];
    mean /= static_cast<double>(used.size() * channels);
    return std::max(0.02 * mean, 1e-6);
}

// The weight W that makes W (f - y)^2 the metric, or where it is not quadratic in f resemble it
// near y: w iz^2 (ngan), iz^2 (l2), w iz^2 times the mean over channels of phi'(iz y)^2 (log,
// cbrt).
float quadratic_weight(const Samples& samples, std::uint32_t k, float solid_angle, Metric metric,
                       double lowest) {
    const double iz = samples.directions->plane(Directions::WiZ)[k];
    const std::size_t channels = samples.channels.size();
    double slopes = quadratic(metric) ? 1 : 0;
    for (std::size_t ch = 0; ch < channels && !quadratic(metric); ++ch) {
        const double x = std::max(iz * samples.channel(ch)[k], lowest);
        const double slope = metric == Metric::Log ? 1 / (1 + x) : std::cbrt(x) / (3 * x);
        slopes += slope * slope / static_cast<double>(channels);
    }
    return static_cast<float>((metric == Metric::L2 ? 1 : solid_angle) * iz * iz * slopes);
}

// `value(k)` of every sample used on the device, then of the padding, which repeats the last one's
// or is 0.
template <typename Value>
cl::Buffer plane(const Device& device, const DeviceSamples& packed, Value value, bool repeat) {
    using T = decltype(value(std::uint32_t{}));
    return filled<T>(device, packed.stride, [&](T* to) {
        parallel_pieces(packed.count, piece, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                to[i] = value(packed.used[i]);
        });
        std::fill(to + packed.count, to + packed.stride, repeat ? value(packed.used.back()) : T{});
    });
}

// Copies what depends on the metric to the device, and the solid angles, which it takes.
void upload_weights(const Device& device, const Samples& samples, Metric metric,
                    DeviceSamples& packed) {
    const bool weighted = !samples.weights.empty();
    double sum = 0;
    for (const std::uint32_t k : packed.used)
        sum += weighted ? samples.weights[k] : 1.0F;
    if (!(sum > 0))
        throw InputError(fmt::format("{}: the weights of the samples used add up to {}; expected "
                                     "a positive sum",
                                     samples.source, sum));
    const double scale = static_cast<double>(packed.count) / sum;
    const auto solid_angle = [&](std::uint32_t k) {
        return static_cast<float>(weighted ? samples.weights[k] * scale : 1);
    };
    const double lowest = quadratic(metric) ? 0 : lowest_slope_at(samples, packed.used);
    if (packed.solid_angle() == nullptr)
        packed.solid_angle = plane(device, packed, solid_angle, false);
    packed.weights = plane(
        device, packed,
        [&](std::uint32_t k) {
            return quadratic_weight(samples, k, solid_angle(k), metric, lowest);
        },
        false);
}

// Copies what of the samples `used` does not depend on the models to the device.
void upload_used(const Device& device, const Samples& samples, Metric metric,
                 DeviceSamples& packed) {
    const std::vector<std::uint32_t>& used = packed.used;
    const auto width = static_cast<std::size_t>(device.form.vector_width);
    const auto local = static_cast<std::size_t>(device.form.local_size);
    const auto block = static_cast<std::size_t>(device.form.block);
    packed.count = used.size();
    packed.groups = (packed.count + block - 1) / block;
    packed.stride = padded(packed.count, width * local);
    packed.channels = static_cast<int>(samples.channels.size());
    packed.chunk = std::min(packed.channels, largest_chunk);
    packed.chunks = (packed.channels + packed.chunk - 1) / packed.chunk;
    packed.isotropic = samples.isotropic;
    packed.pairs = samples.count();

    const float* const wi_z = samples.directions->plane(Directions::WiZ);
    packed.index = plane(
        device, packed, [](std::uint32_t k) { return k; }, true);
    packed.iz = plane(
        device, packed, [&](std::uint32_t k) { return wi_z[k]; }, false);
    upload_weights(device, samples, metric, packed);

    // Vectors in the order of VALUE_AT of kernels/passes/prepare.cl.
    const bool together = local == 1;
    const auto chunk = static_cast<std::size_t>(packed.chunk);
    const std::size_t vectors = packed.stride / width; // a channel
    const std::size_t channels = chunk * static_cast<std::size_t>(packed.chunks);
    packed.values = filled<float>(device, packed.stride * channels, [&](float* to) {
        parallel_pieces(packed.stride, piece, [&](std::size_t begin, std::size_t end) {
            for (std::size_t ch = 0; ch < channels; ++ch) {
                const float* const from =
                    ch < samples.channels.size() ? samples.channel(ch) : nullptr;
                for (std::size_t k = begin; k < end; ++k) {
                    const std::size_t i = k / width;
                    const std::size_t at = together ? VALUE_IN_CHUNK(vectors, i, ch, chunk)
                                                    : VALUE_IN_PLANE(vectors, i, ch);
                    to[at * width + k % width] =
                        from != nullptr && k < packed.count ? from[used[k]] : 0.0F;
                }
            }
        });
    });
}

} // namespace

std::vector<std::uint32_t> used_samples(const Samples& samples, double max_theta_degrees) {
    const double lowest_cosine = std::cos(max_theta_degrees * degree);
    const float* const iz = samples.directions->plane(Directions::WiZ);
    const float* const oz = samples.directions->plane(Directions::WoZ);
    std::vector<std::vector<std::uint32_t>> parts((samples.count() + piece - 1) / piece);
    parallel_pieces(samples.count(), piece, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t>& part = parts[begin / piece];
        for (std::size_t k = begin; k < end; ++k)
            if (samples.valid[k] != 0 && iz[k] > 0 && oz[k] > 0 && iz[k] >= lowest_cosine &&
                oz[k] >= lowest_cosine)
                part.push_back(static_cast<std::uint32_t>(k));
    });
    std::vector<std::uint32_t> used;
    for (const std::vector<std::uint32_t>& part : parts)
        used.insert(used.end(), part.begin(), part.end());
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

DeviceSamples packed_for(Metric metric, const Device& device, const Samples& samples,
                         const DeviceSamples& packed) {
    DeviceSamples other = packed;
    upload_weights(device, samples, metric, other);
    return other;
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

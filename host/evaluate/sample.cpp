#include "host/evaluate/sample.hpp"

#include "host/device/buffer.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/model/program.hpp"
#include "kernels/passes/sample.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace brdfit {

namespace {

constexpr std::size_t most_samples_a_pass = std::size_t{1} << 18;
/// No part of a lobe may be out of the sampler's reach because the table misses it.
constexpr float least_share_of_peak = 1e-3F;

std::uint64_t mixed(std::uint64_t x) { // Steele et al. 2014, splitmix64
    x += 0x9e3779b97f4a7c15U;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31);
}

void check(const Vector& wo, std::size_t n) {
    const double length = std::sqrt(std::inner_product(wo.begin(), wo.end(), wo.begin(), 0.0));
    if (!(std::abs(length - 1) < 1e-6) || !(static_cast<float>(wo[2]) > 0))
        throw UsageError(fmt::format("wo = ({}, {}, {}) is no unit vector above the horizon", wo[0],
                                     wo[1], wo[2]));
    if (n < 1 || n >= std::size_t{1} << 32)
        throw UsageError(fmt::format("{} samples; expected 1 to 2^32 - 1", n));
}

} // namespace

std::array<std::uint32_t, 4> keys_of(std::uint64_t seed, Sequence sequence) {
    std::array<std::uint32_t, 4> keys{};
    if (sequence == Sequence::Philox) {
        keys[0] = static_cast<std::uint32_t>(seed);
        keys[1] = static_cast<std::uint32_t>(seed >> 32);
        return keys;
    }
    for (std::uint64_t dimension = 0; dimension < 3; ++dimension)
        keys[dimension] = static_cast<std::uint32_t>(mixed(mixed(seed) + dimension));
    return keys;
}

Structure drawn_structure(const Material& material) {
    Structure structure;
    structure.diffuse = material.diffuse;
    structure.isotropic = false;
    for (const Lobe& lobe : material.lobes)
        structure.lobes.push_back(lobe.model);
    return structure;
}

DrawnMaterial::DrawnMaterial(const Device& device, const cl::Program& program,
                             const Material& material) {
    const std::size_t channels = material.channels.size(), basis = 1 + material.lobes.size();
    std::vector<double> of_channels(channels * basis), means(basis);
    for (std::size_t j = 0; j < basis; ++j)
        for (std::size_t ch = 0; ch < channels; ++ch) {
            const double value = j == 0 ? material.kd[ch] : material.lobes[j - 1].ks[ch];
            of_channels[ch * basis + j] = value;
            means[j] += value / static_cast<double>(channels);
        }
    // Only ratios matter, and huge coefficients must not overflow.
    const double largest = *std::max_element(means.begin(), means.end());
    for (double& mean : means)
        mean /= largest > 0 ? largest : 1;

    theta = upload(device, device_parameters(material, false));
    coefficients = upload(device, to_float(of_channels));
    strengths = upload(device, to_float(means));
    const std::size_t entries = basis * HEIGHTS * AZIMUTHS;
    table = make_buffer(device, entries * sizeof(float), CL_MEM_READ_WRITE);
    cl::Kernel kernel(program, "tabulate");
    kernel.setArg(0, theta);
    kernel.setArg(1, table);
    const auto local = static_cast<std::size_t>(device.form.local_size);
    device.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(padded(entries, local)),
                                      cl::NDRange(local));
    std::vector<float> albedos = download<float>(device, table, entries);
    for (std::size_t j = 0; j < basis; ++j) {
        const auto begin = albedos.begin() + static_cast<std::ptrdiff_t>(j * HEIGHTS * AZIMUTHS);
        const auto end = begin + HEIGHTS * AZIMUTHS;
        const float least = std::max(least_share_of_peak * *std::max_element(begin, end), 1e-30F);
        std::transform(begin, end, begin, [least](float x) { return std::max(x, least); });
    }
    table = upload(device, albedos);
}

Sampler::Sampler(const Device& device, const Material& material)
    : device_(device), channels_(material.channels.size()),
      program_(build_sample_program(device_, drawn_structure(material))),
      material_(device_, program_, material) {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const std::size_t planes = DRAWN_WEIGHTS + channels_;
    pass_ = std::min(most_samples_a_pass,
                     device_.max_allocation / (sizeof(float) * planes) / width * width);
    out_ = make_buffer(device_, pass_ * planes * sizeof(float), CL_MEM_WRITE_ONLY);
}

void Sampler::draw(const Vector& wo, std::size_t first, std::size_t n, std::uint64_t seed,
                   Sequence sequence) const {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const std::size_t count = padded(n, width) / width;
    cl_float4 direction{};
    for (std::size_t k = 0; k < 3; ++k)
        direction.s[k] = static_cast<float>(wo[k]);
    cl::Kernel kernel(program_, "sample");
    kernel.setArg(0, direction);
    const std::array<std::uint32_t, 4> keys = keys_of(seed, sequence);
    kernel.setArg(1, cl_uint4{{keys[0], keys[1], keys[2], keys[3]}});
    kernel.setArg(2, static_cast<cl_int>(sequence == Sequence::Sobol));
    kernel.setArg(3, static_cast<cl_uint>(first));
    kernel.setArg(4, static_cast<cl_uint>(count));
    kernel.setArg(5, material_.theta);
    kernel.setArg(6, material_.table);
    kernel.setArg(7, material_.strengths);
    kernel.setArg(8, material_.coefficients);
    kernel.setArg(9, static_cast<cl_int>(channels_));
    kernel.setArg(10, out_);
    enqueue_runs(device_, kernel, count);
}

void Sampler::draw(const Vector& wo, std::size_t n, std::uint64_t seed, Sequence sequence) const {
    check(wo, n);
    draw(wo, 0, std::min(n, pass_), seed, sequence);
    device_.queue.finish();
}

DirectionSamples Sampler::sample(const Vector& wo, std::size_t n, std::uint64_t seed,
                                 Sequence sequence, std::size_t first) const {
    check(wo, n);
    check(wo, first + n);
    DirectionSamples samples;
    for (std::vector<float>* column : {&samples.wi_x, &samples.wi_y, &samples.wi_z, &samples.pdf})
        column->resize(n);
    samples.weights.resize(channels_ * n);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    for (std::size_t begin = 0; begin < n; begin += pass_) {
        const std::size_t count = std::min(pass_, n - begin), stride = padded(count, width);
        draw(wo, first + begin, count, seed, sequence);
        const std::vector<float> planes =
            download<float>(device_, out_, stride * (DRAWN_WEIGHTS + channels_));
        const auto fetch = [&](std::size_t plane, float* to) {
            std::copy_n(planes.data() + plane * stride, count, to + begin);
        };
        fetch(DRAWN_WI_X, samples.wi_x.data());
        fetch(DRAWN_WI_Y, samples.wi_y.data());
        fetch(DRAWN_WI_Z, samples.wi_z.data());
        fetch(DRAWN_PDF, samples.pdf.data());
        for (std::size_t ch = 0; ch < channels_; ++ch)
            fetch(DRAWN_WEIGHTS + ch, samples.weights.data() + ch * n);
    }
    return samples;
}

std::vector<float> Sampler::density(const Directions& directions,
                                    const ProgressFunction& progress) const {
    cl::Kernel kernel(program_, "density");
    kernel.setArg(2, material_.theta);
    kernel.setArg(3, material_.table);
    kernel.setArg(4, material_.strengths);
    return run_over_directions(device_, kernel, 5, 1, directions, progress);
}

DirectionSamples sample_material(const Device& device, const Material& material, const Vector& wo,
                                 std::size_t n, std::uint64_t seed, Sequence sequence) {
    return Sampler(device, material).sample(wo, n, seed, sequence);
}

std::vector<float> density(const Device& device, const Material& material,
                           const Directions& directions, const ProgressFunction& progress) {
    return Sampler(device, material).density(directions, progress);
}

} // namespace brdfit

#include "bench/sampling.hpp"

#include "bench/work.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/sample.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit::bench {

namespace {

constexpr std::size_t samples_for_variance = 1 << 18;
constexpr std::uint64_t seed = 1;
constexpr double roughness = 0.2;

struct Moments {
    double mean = 0, variance = 0;
};

/// Of the weights' mean over channels, [channel][sample].
Moments moments(const std::vector<float>& weights, std::size_t count, double scale) {
    const std::size_t channels = weights.size() / count;
    double sum = 0, squares = 0;
    for (std::size_t k = 0; k < count; ++k) {
        double x = 0;
        for (std::size_t ch = 0; ch < channels; ++ch)
            x += weights[ch * count + k] * scale / static_cast<double>(channels);
        sum += x;
        squares += x * x;
    }
    const double n = static_cast<double>(count), mean = sum / n;
    return {mean, std::max(0.0, squares / n - mean * mean)};
}

double cosine_variance(const Device& device, const Material& material, const Vector& wo) {
    Material cosine;
    cosine.channels = {"Y"};
    cosine.diffuse = &model_named("lambert");
    cosine.kd = {1};
    const DirectionSamples samples =
        sample_material(device, cosine, wo, samples_for_variance, seed, Sequence::Philox);
    Directions directions(samples.count());
    for (std::size_t k = 0; k < samples.count(); ++k)
        directions.set(k, {samples.wi_x[k], samples.wi_y[k], samples.wi_z[k]}, wo);
    // f iz / (iz / pi)
    return moments(evaluate(device, material, directions), samples.count(), pi).variance;
}

} // namespace

std::vector<NamedMaterial> catalogue_materials() {
    std::vector<NamedMaterial> materials;
    for (const Model& model : catalogue()) {
        if (model.kind != Kind::Lobe)
            continue;
        Lobe lobe{&model, true, {}, {1}};
        for (const Parameter& p : model.isotropic) {
            double value = p.start;
            if (p.scale == Scale::Log)
                value = roughness;
            if (p.scale == Scale::Log1p)
                value = 2 / (roughness * roughness);
            lobe.theta.push_back(value);
        }
        Material material;
        material.channels = {"Y"};
        material.diffuse = &model_named("lambert");
        material.kd = {0};
        material.lobes = {lobe};
        materials.push_back({model.name, material});
    }
    return materials;
}

SamplingResult measure_sampling(const Device& device, const NamedMaterial& named, double theta_o) {
    const Vector wo = direction(theta_o, 0);
    const Sampler sampler(device, named.material);
    SamplingResult result;
    result.name = named.name;
    const DirectionSamples samples =
        sampler.sample(wo, samples_for_variance, seed, Sequence::Philox);
    const Moments found = moments(samples.weights, samples.count(), 1);
    result.albedo = found.mean;
    result.variance = found.variance;
    result.cosine_variance = cosine_variance(device, named.material, wo);
    result.rejected =
        static_cast<double>(std::count(samples.pdf.begin(), samples.pdf.end(), 0.0F)) /
        static_cast<double>(samples.count());
    const std::size_t n = sampler.samples_a_pass();
    const auto speed = [&](Sequence sequence) {
        const Timing timing = time_runs([&] { sampler.draw(wo, n, seed, sequence); });
        return static_cast<double>(n) / timing.median;
    };
    result.sobol = speed(Sequence::Sobol);
    result.philox = speed(Sequence::Philox);
    return result;
}

nlohmann::ordered_json to_json(const SamplingResult& result) {
    return {{"name", result.name},
            {"albedo", result.albedo},
            {"variance", result.variance},
            {"cosine_variance", result.cosine_variance},
            {"rejected", result.rejected},
            {"sobol_samples_per_second", result.sobol},
            {"philox_samples_per_second", result.philox}};
}

} // namespace brdfit::bench

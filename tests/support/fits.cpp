#include "tests/support/fits.hpp"

#include "fit/programs.hpp"
#include "fit/structures.hpp"
#include "tests/support/reference_models.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::test {

ProgramCache& programs() {
    static ProgramCache cache(device());
    return cache;
}

FitDevices& fit_devices() {
    static FitDevices devices({device()});
    return devices;
}

bool has_anisotropic_form(const Structure& structure) {
    return std::any_of(structure.lobes.begin(), structure.lobes.end(), [](const Model* model) {
        return model->isotropic.size() != model->anisotropic.size();
    });
}

Material typical_material(const Structure& structure, std::size_t channels) {
    Material material;
    material.diffuse = structure.diffuse;
    for (std::size_t ch = 0; ch < channels; ++ch) {
        material.channels.push_back(fmt::format("c{}", ch));
        material.kd.push_back(0.1 + 0.2 * static_cast<double>(ch) / static_cast<double>(channels));
    }
    // Each further roughness is wider than the one before, each exponent smaller.
    double factor = 1;
    for (const Model* model : structure.lobes) {
        Lobe lobe{model, structure.isotropic, {}, {}};
        for (const Parameter& p : model->parameters(structure.isotropic)) {
            if (!p.width()) {
                lobe.theta.push_back(p.start);
                continue;
            }
            const double value = p.start * (p.scale == Scale::Log ? factor : 1 / factor);
            lobe.theta.push_back(std::clamp(value, p.lower, p.upper));
            factor *= 1.7;
        }
        for (std::size_t ch = 0; ch < channels; ++ch)
            lobe.ks.push_back(
                (0.5 - 0.3 * static_cast<double>(ch) / static_cast<double>(channels)) * factor /
                1.7);
        material.lobes.push_back(lobe);
    }
    return material;
}

Samples measured(const Material& material, std::size_t count, double noise, unsigned long seed) {
    Samples samples = synthesise(device(), material,
                                 random_directions(count, material.isotropic(), seed), noise, seed);
    samples.source = "measured";
    return samples;
}

FitResult fit(const Samples& samples, const Structure& structure, const FitOptions& options) {
    return FileFitter(device(), programs(), samples, options).fit(structure);
}

FitResult fit(const Samples& samples, const std::string& model, int lobes,
              const FitOptions& options) {
    return fit(samples, structure_named(model, lobes, "", samples.isotropic), options);
}

double error_of(const FitResult& result, Metric metric) {
    return result.errors[static_cast<std::size_t>(metric)];
}

double compressed(Metric metric, double x) {
    if (metric == Metric::Log)
        return std::log1p(std::max(x, 0.0));
    // The odd cubic u (4 - u^2) / 3 has the value and the slope of cbrt at u = 1.
    constexpr double edge = 1e-6;
    const double u = x / edge;
    return std::abs(u) < 1 ? std::cbrt(edge) * u * (4 - u * u) / 3 : std::cbrt(x);
}

MetricErrors reference_errors(const Material& material, const Samples& samples, double max_theta) {
    const double lowest = std::cos(max_theta * degree);
    MetricErrors sums{};
    double weights = 0, count = 0;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        const double iz = samples.directions->plane(Directions::WiZ)[k];
        const double oz = samples.directions->plane(Directions::WoZ)[k];
        if (samples.valid[k] == 0 || iz <= 0 || oz <= 0 || iz < lowest || oz < lowest)
            continue;
        const double w = samples.weights.empty() ? 1.0 : samples.weights[k];
        weights += w;
        ++count;
        const auto [wi, wo] = samples.directions->pair(k);
        for (std::size_t ch = 0; ch < samples.channels.size(); ++ch) {
            const double f = iz * reference_evaluate(material, ch, wi, wo);
            const double y = iz * samples.channel(ch)[k];
            const auto squared = [&](Metric metric) {
                return std::pow(compressed(metric, f) - compressed(metric, y), 2);
            };
            sums[static_cast<std::size_t>(Metric::Ngan)] += w * (f - y) * (f - y);
            sums[static_cast<std::size_t>(Metric::L2)] += (f - y) * (f - y);
            sums[static_cast<std::size_t>(Metric::Log)] += w * squared(Metric::Log);
            sums[static_cast<std::size_t>(Metric::Cbrt)] += w * squared(Metric::Cbrt);
        }
    }
    const auto channels = static_cast<double>(samples.channels.size());
    for (std::size_t i = 0; i < sums.size(); ++i)
        sums[i] = std::sqrt(sums[i] / channels /
                            (i == static_cast<std::size_t>(Metric::L2) ? count : weights));
    return sums;
}

} // namespace brdfit::test

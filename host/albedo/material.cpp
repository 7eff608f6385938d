#include "host/albedo/material.hpp"

#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/microfacet/reflectance.hpp"
#include "host/parallel.hpp"
#include "host/quadrature.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <utility>

namespace brdfit {

namespace {

/// Nodes of the hemispherical albedo: doubled until two agree.
constexpr std::size_t fewest_nodes = 16, most_nodes = 256;
/// The first nodes are nearer to the horizon than a limit (see AlbedoIntegrator) and weigh nothing.
constexpr double least_cosine = 1e-8;
/// Azimuths of an anisotropic material's.
constexpr std::size_t average_azimuths = 32;

/// What a table already knows: R of its lobe, or what that leaves to the diffuse term, 1 - R or of
/// a metal f0 max(0, f0 - R).
struct Tabulated {
    std::shared_ptr<const MicrofacetTable> table;
    TableReflectance reflectance;
    bool diffuse = false, metal = false, vanishes = false;
    double f0 = 0;

    AlbedoValue value(const AlbedoTask& task) const {
        AlbedoValue found;
        const double scale = diffuse && metal ? f0 : 1, r = reflectance.at(task.wo);
        const double interpolation = scale * reflectance.interpolation_error(task.wo);
        found.all = vanishes ? 0 : diffuse ? scale * std::max(0.0, (metal ? f0 : 1) - r) : r;
        found.error = vanishes ? 0 : interpolation + scale * TableReflectance::node_error;
        found.reached = interpolation <= task.tolerance;
        return found;
    }
};

/// One component of a material: its share of R in each channel and what says or integrates it.
struct Component {
    std::vector<double> coefficients;
    std::optional<AlbedoIntegrator> integrator;
    std::optional<Tabulated> tabulated;
    std::vector<double> theta;
    double tolerance;

    std::vector<AlbedoValue> values(const std::vector<AlbedoTask>& tasks,
                                    const ProgressFunction& progress) {
        if (!tabulated)
            return integrator->integrate(tasks, progress);
        std::vector<AlbedoValue> found(tasks.size());
        parallel_pieces(tasks.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t < end; ++t)
                found[t] = tabulated->value(tasks[t]);
        });
        return found;
    }
};

/// What the lobe's table says of the component: of the lobe itself, or of the diffuse term of the
/// paper. Nothing where a better tolerance is wanted, or where it has no such table.
std::optional<Tabulated> tabulated(const Material& material, const Lobe& lobe, bool diffuse,
                                   double tolerance) {
    const std::string& name = diffuse ? material.diffuse->name : lobe.model->name;
    if (lobe.table == nullptr || tolerance < TableReflectance::node_error ||
        name != (diffuse ? "microfacet-diffuse" : "microfacet"))
        return std::nullopt;
    const double f0 = lobe.theta.at(0);
    const bool metal = diffuse && material.metal;
    return Tabulated{lobe.table,
                     TableReflectance(*lobe.table, f0, lobe.correlated),
                     diffuse,
                     metal,
                     diffuse && diffuse_constant(*lobe.table, {f0, lobe.correlated, metal}) == 0,
                     f0};
}

std::vector<Component> components_of(const Device& device, const Material& material,
                                     double tolerance) {
    std::vector<std::vector<double>> coefficients{material.kd};
    for (const Lobe& lobe : material.lobes)
        coefficients.push_back(lobe.ks);
    const auto largest = [](const std::vector<double>& values) {
        return *std::max_element(values.begin(), values.end());
    };
    const auto used = static_cast<double>(
        std::count_if(coefficients.begin(), coefficients.end(),
                      [&](const std::vector<double>& c) { return largest(c) > 0; }));
    std::vector<Component> components;
    for (std::size_t j = 0; j < coefficients.size(); ++j) {
        if (!(largest(coefficients[j]) > 0))
            continue;
        // A program a component: others with the same model share it.
        Structure structure;
        structure.diffuse = j == 0 ? material.diffuse : &model_named("lambert");
        std::vector<double> theta;
        std::vector<float> shared;
        std::optional<Tabulated> known;
        const bool needs_lobe = j > 0 || material.diffuse->kind == Kind::DiffuseAndLobe;
        if (needs_lobe) {
            const Lobe& lobe = material.lobes.at(j == 0 ? 0 : j - 1);
            structure.lobes.push_back(lobe.model);
            theta = lobe.anisotropic_theta();
            if (lobe.model->table) {
                Material alone = material;
                alone.lobes = {lobe};
                known = tabulated(material, lobe, j == 0, tolerance);
                if (!known)
                    shared = device_parameters(alone, false);
            }
        }
        components.push_back({coefficients[j], std::nullopt, std::move(known), theta,
                              tolerance / used / largest(coefficients[j])});
        if (!components.back().tabulated)
            components.back().integrator.emplace(device, structure, j == 0 ? 0 : 1, shared);
    }
    return components;
}

struct Estimate {
    double value = 0, error = 0;
    bool reached = true;
};

/// R by [channel][direction]; `slack` multiplies the tolerance at each direction.
std::vector<std::vector<Estimate>> directional(std::vector<Component>& components,
                                               const std::vector<Vector>& wo,
                                               const std::vector<double>& slack,
                                               std::size_t channels,
                                               const ProgressFunction& progress) {
    std::vector<std::vector<Estimate>> sums(channels, std::vector<Estimate>(wo.size()));
    double done = 0;
    for (Component& component : components) {
        std::vector<AlbedoTask> tasks;
        for (std::size_t k = 0; k < wo.size(); ++k)
            tasks.push_back({wo[k], component.theta, component.tolerance * slack[k], 0});
        const double end = done + 1 / static_cast<double>(components.size());
        const std::vector<AlbedoValue> values =
            component.values(tasks, part_of(progress, std::exchange(done, end), end));
        for (std::size_t ch = 0; ch < channels; ++ch)
            for (std::size_t k = 0; k < wo.size(); ++k) {
                if (component.coefficients[ch] == 0) // 0 of an infinite albedo is nothing
                    continue;
                sums[ch][k].value += component.coefficients[ch] * values[k].all;
                sums[ch][k].error += component.coefficients[ch] * values[k].error;
                sums[ch][k].reached &= values[k].reached;
            }
    }
    return sums;
}

// Sets values and errors of an albedo at its viewers, with a note where the tolerance was not
// reached.
void add_directional(Albedo& result, std::vector<Component>& components,
                     const ProgressFunction& progress) {
    const std::size_t channels = result.channels.size();
    std::vector<Vector> wo;
    for (std::size_t k = 0; k < result.count(); ++k) {
        wo.push_back(direction(result.theta[k], result.phi[k]));
        if (result.theta[k] >= pi / 2)
            wo.back()[2] = 0; // the limit, not what rounding leaves
    }
    const auto found =
        directional(components, wo, std::vector<double>(wo.size(), 1), channels, progress);
    std::size_t missed = 0;
    double largest = 0;
    for (std::size_t ch = 0; ch < channels; ++ch) {
        result.values.emplace_back();
        result.errors.emplace_back();
        for (const Estimate& estimate : found[ch]) {
            result.values.back().push_back(estimate.value);
            result.errors.back().push_back(std::isfinite(estimate.value) ? estimate.error : 0);
            missed += !estimate.reached;
            if (!estimate.reached)
                largest = std::max(largest, estimate.error);
        }
    }
    if (missed > 0)
        result.notes.push_back(fmt::format("{} of {} values did not reach the tolerance; the "
                                           "largest error is {:.2g}",
                                           missed, channels * wo.size(), largest));
}

// The hemispherical albedo of each channel by a rule of `nodes` cosines at `azimuths`.
std::vector<Estimate> average_over(std::vector<Component>& components, std::size_t azimuths,
                                   std::size_t nodes, std::size_t channels,
                                   const ProgressFunction& progress) {
    const CosineRule rule(nodes);
    std::vector<Vector> at;
    std::vector<double> slack;
    for (std::size_t a = 0; a < azimuths; ++a)
        for (std::size_t i = 0; i < nodes; ++i) {
            const double mu = std::max(rule.mu[i], least_cosine);
            slack.push_back(std::max(1.0, 1 / (rule.weight[i] * static_cast<double>(nodes))));
            const double r = std::sqrt((1 - mu) * (1 + mu));
            const double phi =
                2 * pi * (static_cast<double>(a) + 0.5) / static_cast<double>(azimuths);
            at.push_back({r * std::cos(phi), r * std::sin(phi), mu});
        }
    const auto estimates = directional(components, at, slack, channels, progress);
    std::vector<Estimate> sums(channels);
    for (std::size_t ch = 0; ch < channels; ++ch)
        for (std::size_t k = 0; k < at.size(); ++k) {
            const double weight = rule.weight[k % nodes] / static_cast<double>(azimuths);
            sums[ch].value += weight * estimates[ch][k].value;
            sums[ch].error += weight * estimates[ch][k].error;
        }
    return sums;
}

// The hemispherical albedo of each channel; as many nodes as it takes.
std::vector<Estimate> hemispherical(std::vector<Component>& components, std::size_t azimuths,
                                    std::size_t channels, double tolerance,
                                    const ProgressFunction& progress) {
    double done = 0.3; // two rounds, as a rule
    std::vector<Estimate> coarse = average_over(components, azimuths, fewest_nodes, channels,
                                                part_of(progress, 0, done)),
                          fine;
    for (std::size_t nodes = 2 * fewest_nodes; nodes <= most_nodes; nodes *= 2) {
        const double end = done + 0.7 * (1 - done);
        fine = average_over(components, azimuths, nodes, channels,
                            part_of(progress, std::exchange(done, end), end));
        double change = 0;
        for (std::size_t ch = 0; ch < channels; ++ch) {
            const double step = std::abs(fine[ch].value - coarse[ch].value);
            fine[ch].error += std::isfinite(fine[ch].value) ? step : 0;
            change = std::max(change, std::isfinite(step) ? step : 0);
        }
        if (change <= tolerance)
            break;
        coarse = fine;
    }
    return fine;
}

} // namespace

void AlbedoGrid::place(Albedo& albedo) const {
    albedo.columns = thetas;
    for (std::size_t j = 0; j < phis; ++j)
        for (std::size_t i = 0; i < thetas; ++i) {
            albedo.theta.push_back(pi / 2 * static_cast<double>(i) /
                                   static_cast<double>(thetas - 1));
            albedo.phi.push_back(2 * pi * static_cast<double>(j) / static_cast<double>(phis));
        }
}

CosineRule::CosineRule(std::size_t count, double split) {
    const double end = split > 0 ? split : 1;
    const std::size_t below = split > 0 ? count / 2 : count;
    const Quadrature lower = gauss_legendre(below);
    for (std::size_t i = lower.size(); i-- > 0;) { // from the normal down
        const double x = lower.x[i], w = lower.w[i];
        // mu = end x^4: 2 mu dmu = 8 end^2 x^7 dx
        mu.push_back(end * x * x * x * x);
        weight.push_back(8 * end * end * std::pow(x, 7) * w);
    }
    if (split > 0) {
        const Quadrature upper = gauss_legendre(count - below);
        for (std::size_t i = upper.size(); i-- > 0;) {
            const double x = upper.x[i];
            mu.push_back(split + (1 - split) * x * x);
            weight.push_back(4 * mu.back() * (1 - split) * x * upper.w[i]);
        }
    }
}

void require_tolerance(double tolerance) {
    if (!(tolerance >= least_tolerance && tolerance < 1))
        throw UsageError(fmt::format("tolerance {}: expected a number from {} (what single "
                                     "precision reaches) to below 1",
                                     tolerance, least_tolerance));
}

Albedo directional_albedo(const Device& device, const Material& material, std::vector<double> theta,
                          std::vector<double> phi, double tolerance,
                          const ProgressFunction& progress) {
    require_tolerance(tolerance);
    Albedo result;
    result.channels = material.channels;
    result.theta = std::move(theta);
    result.phi = std::move(phi);
    std::vector<Component> components = components_of(device, material, tolerance);
    add_directional(result, components, progress);
    return result;
}

Albedo albedo(const Device& device, const Material& material, const AlbedoGrid& grid,
              double tolerance, const ProgressFunction& progress) {
    require_tolerance(tolerance);
    Albedo result;
    result.channels = material.channels;
    grid.place(result);
    const std::size_t channels = material.channels.size();
    std::vector<Component> components = components_of(device, material, tolerance);
    const std::size_t azimuths = material.isotropic() ? 1 : average_azimuths;
    // By how many directions the two parts look at.
    const auto viewers = static_cast<double>(result.count()),
               averaged = static_cast<double>(3 * fewest_nodes * azimuths);
    const double split = viewers / (viewers + averaged);
    add_directional(result, components, part_of(progress, 0, split));

    for (const Estimate& estimate :
         hemispherical(components, azimuths, channels, tolerance, part_of(progress, split, 1))) {
        result.average.push_back(estimate.value);
        result.average_error.push_back(std::isfinite(estimate.value) ? estimate.error : 0);
    }
    const auto of_tables =
        std::count_if(components.begin(), components.end(),
                      [](const Component& component) { return component.tabulated.has_value(); });
    if (of_tables > 0)
        result.notes.push_back(fmt::format(
            "{} of {} components taken from R0 and R1 of their microfacet tables, errors {} and "
            "the interpolation's; a tolerance below that integrates them",
            of_tables, components.size(), TableReflectance::node_error));
    result.notes.push_back(fmt::format(
        "tolerance {}; errors estimated, six standard errors of 16 independent estimates",
        tolerance));
    return result;
}

} // namespace brdfit

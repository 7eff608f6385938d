#include "fit/conserve.hpp"

#include "fit/space.hpp"
#include "host/albedo/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brdfit {

namespace {

// Half the step of difference quotients, in the scales' coordinates: float32 rounds what is below.
constexpr double difference = 2e-3;
// A hundredth of this may be missed at the horizon by albedos that are to be smooth.
constexpr double smooth_tolerance = 0.05;

// What each component's albedo may be off by for a material's to be within `tolerance`; infinite
// for a component of no strength.
std::vector<double> component_tolerances(const Eigen::MatrixXd& a, double tolerance) {
    const Eigen::VectorXd largest = a.colwise().maxCoeff();
    const auto used = static_cast<double>((largest.array() > 0).count());
    std::vector<double> tolerances;
    for (const double strength : largest)
        tolerances.push_back(tolerance / (used * strength));
    return tolerances;
}

std::vector<double> conserved_thetas() {
    std::vector<double> thetas;
    for (int degree = 0; degree <= conserved_theta; ++degree)
        thetas.push_back(degree);
    return thetas;
}

// From components' albedos of viewers at `thetas`, for each of some azimuths.
LargestAlbedo largest_of(const Eigen::MatrixXd& components, const std::vector<double>& thetas,
                         const std::vector<std::string>& channels, const Eigen::MatrixXd& a) {
    const Eigen::MatrixXd r = material_albedos(a, components);
    Eigen::Index channel = 0, viewer = 0;
    LargestAlbedo largest;
    largest.value = r.maxCoeff(&channel, &viewer);
    largest.theta = thetas[static_cast<std::size_t>(viewer) % thetas.size()];
    largest.channel = channels[static_cast<std::size_t>(channel)];
    return largest;
}

} // namespace

std::vector<Vector> viewers_at(const std::vector<double>& thetas, const Structure& structure,
                               std::size_t azimuths, const std::vector<double>& theta) {
    std::vector<Vector> wo;
    std::size_t count = structure.isotropic ? 1 : azimuths;
    double first = 0;
    if (structure.turns()) {
        const std::vector<Parameter> parameters = layout_of(structure).parameters;
        const auto angle = std::find_if(parameters.begin(), parameters.end(),
                                        [](const Parameter& p) { return p.scale == Scale::Angle; });
        first = theta.at(static_cast<std::size_t>(angle - parameters.begin())) * degree;
        if (structure.lobes.size() > 1) // which lie anyhow to each other
            azimuths = std::max<std::size_t>(azimuths, 10);
        count = 2 * (azimuths - 1);
    }
    for (std::size_t i = 0; i < count; ++i)
        for (const double polar : thetas)
            wo.push_back(direction(polar * pi / 180,
                                   i == 0 ? first
                                          : first + pi / 2 * static_cast<double>(i) /
                                                        static_cast<double>(azimuths - 1)));
    return wo;
}

ComponentAlbedos::ComponentAlbedos(ProgramCache& programs, Structure structure)
    : programs_(programs), structure_(std::move(structure)), layout_(layout_of(structure_)) {}

// Whether a component's albedo is 1 whatever wo and theta.
bool ComponentAlbedos::constant(std::size_t component) const {
    return component == 0 && structure_.diffuse->name == "lambert";
}

std::vector<double> ComponentAlbedos::own(std::size_t component,
                                          const std::vector<double>& theta) const {
    if (component == 0 && !structure_.coupled())
        return {};
    const std::size_t l = component == 0 ? 0 : component - 1;
    return Lobe{structure_.lobes[l],
                structure_.isotropic,
                {theta.begin() + layout_.lobe_begin[l], theta.begin() + layout_.lobe_begin[l + 1]},
                {}}
        .anisotropic_theta();
}

std::vector<double> ComponentAlbedos::values(std::size_t component,
                                             const std::vector<AlbedoTask>& tasks) const {
    const Model* lobe = component > 0          ? structure_.lobes[component - 1]
                        : structure_.coupled() ? structure_.lobes[0]
                                               : nullptr;
    std::vector<double> all;
    for (const AlbedoValue& value :
         programs_.albedos(component == 0 ? structure_.diffuse : nullptr, lobe, tasks))
        all.push_back(value.all);
    return all;
}

Eigen::MatrixXd ComponentAlbedos::at(const std::vector<double>& theta,
                                     const std::vector<Vector>& wo,
                                     const std::vector<double>& tolerance, double relative) const {
    Eigen::MatrixXd albedos =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(wo.size()), layout_.basis);
    for (std::size_t j = 0; j < tolerance.size(); ++j) {
        if (!(tolerance[j] < std::numeric_limits<double>::infinity()))
            continue;
        auto column = albedos.col(static_cast<Eigen::Index>(j));
        if (constant(j)) {
            column.setOnes();
            continue;
        }
        std::vector<AlbedoTask> tasks;
        for (const Vector& w : wo)
            tasks.push_back({w, own(j, theta), tolerance[j], 0, relative});
        const std::vector<double> found = values(j, tasks);
        column = Eigen::Map<const Eigen::VectorXd>(found.data(), column.size());
    }
    return albedos;
}

Eigen::MatrixXd ComponentAlbedos::smooth(const std::vector<double>& theta,
                                         const std::vector<Vector>& wo,
                                         std::uint32_t points) const {
    Eigen::MatrixXd albedos =
        Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(wo.size()), layout_.basis);
    for (std::size_t j = 0; j < static_cast<std::size_t>(layout_.basis); ++j) {
        if (constant(j))
            continue;
        std::vector<AlbedoTask> tasks;
        for (const Vector& w : wo)
            tasks.push_back({w, own(j, theta), smooth_tolerance, 0, 0, points});
        const std::vector<double> found = values(j, tasks);
        auto column = albedos.col(static_cast<Eigen::Index>(j));
        column = Eigen::Map<const Eigen::VectorXd>(found.data(), column.size());
    }
    return albedos;
}

Eigen::MatrixXd ComponentAlbedos::smooth_by_theta(const std::vector<double>& theta,
                                                  const std::vector<Vector>& wo,
                                                  std::uint32_t points) const {
    const auto viewers = static_cast<Eigen::Index>(wo.size());
    Eigen::MatrixXd slopes =
        Eigen::MatrixXd::Zero(viewers, static_cast<Eigen::Index>(layout_.entries.size()));
    for (int j = 0; j < layout_.basis; ++j) {
        const auto component = static_cast<std::size_t>(j);
        std::vector<AlbedoTask> tasks;
        std::vector<std::pair<Eigen::Index, double>> steps; // entry, its theta's step
        for (std::size_t e = 0; e < layout_.entries.size(); ++e) {
            if (layout_.entries[e].basis != j)
                continue;
            const auto p = static_cast<std::size_t>(layout_.entries[e].parameter);
            const Scale scale = layout_.parameters[p].scale;
            const double step = difference * slope_of_scale(scale, theta[p]);
            steps.emplace_back(static_cast<Eigen::Index>(e), step);
            for (const double moved : {theta[p] + step, theta[p] - step}) {
                std::vector<double> there = theta;
                there[p] = moved;
                for (const Vector& w : wo)
                    tasks.push_back({w, own(component, there), smooth_tolerance, 0, 0, points});
            }
        }
        const std::vector<double> found = values(component, tasks);
        const double* value = found.data();
        for (const auto& [entry, step] : steps) {
            const Eigen::Map<const Eigen::VectorXd> above(value, viewers),
                below(value + viewers, viewers);
            value += 2 * viewers;
            slopes.col(entry) = (above - below) / (2 * step);
        }
    }
    return slopes;
}

Eigen::MatrixXd material_albedos(const Eigen::MatrixXd& a, const Eigen::MatrixXd& components) {
    Eigen::MatrixXd albedos = Eigen::MatrixXd::Zero(a.rows(), components.rows());
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch)
        for (Eigen::Index j = 0; j < a.cols(); ++j)
            if (a(ch, j) > 0)
                albedos.row(ch) += a(ch, j) * components.col(j).transpose();
    return albedos;
}

Eigen::MatrixXd scaled_below_1(const Eigen::MatrixXd& a, const Eigen::MatrixXd& components) {
    Eigen::MatrixXd scaled = a;
    for (Eigen::Index j = 0; j < a.cols(); ++j)
        if (!components.col(j).allFinite())
            scaled.col(j).setZero();
    const Eigen::VectorXd largest = material_albedos(scaled, components).rowwise().maxCoeff();
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch)
        scaled.row(ch) /= std::max(1.0, largest[ch]);
    return scaled;
}

Eigen::MatrixXd AlbedoLimit::at(const std::vector<double>& theta) const {
    if (points > 0)
        return albedos.smooth(theta, wo, points);
    return albedos.at(theta, wo, tolerance, conserved_tolerance / 4);
}

AlbedoLimit limit_at_every_degree(const ComponentAlbedos& albedos, const std::vector<double>& theta,
                                  const Eigen::MatrixXd& a) {
    constexpr std::size_t azimuths = 10; // every ten degrees
    // What has no strength may be given some.
    const double least = std::max(0.1 * a.maxCoeff(), 1e-30);
    return {albedos, viewers_at(conserved_thetas(), albedos.structure(), azimuths, theta), 0,
            component_tolerances(a.cwiseMax(least), conserved_tolerance / 4)};
}

LargestAlbedo largest_albedo(const ComponentAlbedos& albedos,
                             const std::vector<std::string>& channels,
                             const std::vector<double>& theta, const Eigen::MatrixXd& a) {
    const std::vector<double> thetas{0, 15, 30, 45, 60, 70, 75, 80, 85};
    return largest_of(albedos.at(theta, viewers_at(thetas, albedos.structure(), 3, theta),
                                 component_tolerances(a, LargestAlbedo::albedo_tolerance),
                                 LargestAlbedo::albedo_tolerance),
                      thetas, channels, a);
}

LargestAlbedo largest_conserved_albedo(const ComponentAlbedos& albedos,
                                       const std::vector<std::string>& channels,
                                       const std::vector<double>& theta, const Eigen::MatrixXd& a) {
    return largest_of(limit_at_every_degree(albedos, theta, a).at(theta), conserved_thetas(),
                      channels, a);
}

} // namespace brdfit

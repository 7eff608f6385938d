#include "fit/conserve.hpp"

#include "host/albedo/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brdfit {

std::vector<Vector> viewers_at(const std::vector<double>& thetas, bool isotropic,
                               std::size_t azimuths) {
    std::vector<Vector> wo;
    for (std::size_t i = 0; i < (isotropic ? 1 : azimuths); ++i)
        for (const double theta : thetas)
            wo.push_back(direction(
                theta * pi / 180,
                i == 0 ? 0 : pi / 2 * static_cast<double>(i) / static_cast<double>(azimuths - 1)));
    return wo;
}

ComponentAlbedos::ComponentAlbedos(ProgramCache& programs, Structure structure)
    : programs_(programs), structure_(std::move(structure)), layout_(layout_of(structure_)) {}

Eigen::MatrixXd ComponentAlbedos::at(const std::vector<double>& theta,
                                     const std::vector<Vector>& wo,
                                     const std::vector<double>& tolerance, double relative) const {
    Eigen::MatrixXd albedos =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(wo.size()), layout_.basis);
    for (std::size_t j = 0; j < tolerance.size(); ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        if (!(tolerance[j] < std::numeric_limits<double>::infinity()))
            continue;
        if (j == 0 && structure_.diffuse->name == "lambert") {
            albedos.col(column).setOnes();
            continue;
        }
        std::vector<double> own;
        const Model* lobe = nullptr;
        if (j > 0 || structure_.coupled()) {
            const std::size_t l = j == 0 ? 0 : j - 1;
            lobe = structure_.lobes[l];
            own = Lobe{
                lobe,
                structure_.isotropic,
                {theta.begin() + layout_.lobe_begin[l], theta.begin() + layout_.lobe_begin[l + 1]},
                {}}.anisotropic_theta();
        }
        std::vector<AlbedoTask> tasks;
        for (const Vector& w : wo)
            tasks.push_back({w, own, tolerance[j], 0, relative});
        const std::vector<AlbedoValue> values =
            programs_.albedos(j == 0 ? structure_.diffuse : nullptr, lobe, tasks);
        for (std::size_t k = 0; k < wo.size(); ++k)
            albedos(static_cast<Eigen::Index>(k), column) = values[k].all;
    }
    return albedos;
}

LargestAlbedo largest_albedo(const ComponentAlbedos& albedos, const Structure& structure,
                             const std::vector<std::string>& channels,
                             const std::vector<double>& theta, const Eigen::MatrixXd& a) {
    const std::vector<double> thetas{0, 15, 30, 45, 60, 70, 75, 80, 85};
    std::vector<double> tolerance;
    const Eigen::VectorXd largest = a.colwise().maxCoeff();
    const auto used = static_cast<double>((largest.array() > 0).count());
    for (const double strength : largest) // infinite for a component of no strength
        tolerance.push_back(LargestAlbedo::albedo_tolerance / (used * strength));
    const Eigen::MatrixXd r = albedos.at(theta, viewers_at(thetas, structure.isotropic, 3),
                                         tolerance, LargestAlbedo::albedo_tolerance);
    LargestAlbedo found{0, 0, channels.front()};
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch)
        for (Eigen::Index k = 0; k < r.rows(); ++k) {
            double value = 0;
            for (Eigen::Index j = 0; j < a.cols(); ++j)
                if (a(ch, j) > 0) // 0 of an infinite albedo is nothing
                    value += a(ch, j) * r(k, j);
            if (value > found.value)
                found = {value, thetas[static_cast<std::size_t>(k) % thetas.size()],
                         channels[static_cast<std::size_t>(ch)]};
        }
    return found;
}

} // namespace brdfit

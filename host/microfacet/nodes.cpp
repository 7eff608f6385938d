#include "host/microfacet/nodes.hpp"
#include "host/quadrature.hpp"
#include "kernels/terms/table_words.h"

#include <algorithm>
#include <cmath>

namespace brdfit {

double least_theta(const DistributionPart& part) {
    // exp(-cot^2 / sigma^2) has vanished below.
    return part.shape == Shape::Velvet ? std::atan(1 / (double{REACH} * part.sigma_x)) : 0;
}

double greatest_theta(const DistributionPart& part) {
    return part.shape == Shape::Tabulated ? std::max(pi / 2, part.table->thetas.back()) : pi / 2;
}

std::array<double, 2> azimuth_stretch(const DistributionPart& part) {
    if (part.shape != Shape::Gaussian)
        return {1, 1};
    return {std::min(part.sigma_x, 1.0), std::min(part.sigma_y, 1.0)};
}

PartNodes nodes_of(const DistributionPart& part, std::size_t fineness) {
    PartNodes nodes;
    const bool image = part.table != nullptr && !part.table->tabulated();
    const std::size_t rows = (image ? 512 : 256) * fineness,
                      columns = (image ? 256 : 128) * fineness;
    std::vector<double> share_ends{0, 1}, psi_ends{0, pi / 2, pi, 3 * pi / 2, 2 * pi};
    if (part.shape == Shape::Tabulated) {
        const double end = greatest_theta(part);
        for (const double theta : part.table->thetas)
            if (theta / end > share_ends[share_ends.size() - 2] && theta < end)
                share_ends.insert(share_ends.end() - 1, theta / end);
        if (part.table->width > 1) {
            psi_ends = part.table->phis;
            psi_ends.push_back(psi_ends.front() + 2 * pi);
        }
    }
    const auto each = [](std::size_t wanted, std::size_t panels, std::size_t least) {
        return std::max(least, wanted / panels);
    };
    nodes.shares = gauss_legendre(share_ends, each(rows, share_ends.size() - 1, 2));
    nodes.psis = gauss_legendre(psi_ends, each(4 * columns, psi_ends.size() - 1, 2));
    return nodes;
}

} // namespace brdfit

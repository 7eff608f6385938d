#include "fit/distribution_nodes.hpp"

#include "host/parallel.hpp"
#include "host/quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit {

namespace {

constexpr std::size_t isotropic_thetas = 91, anisotropic_thetas = 31;
constexpr std::size_t azimuths_of_p = 36;
constexpr std::size_t columns_of_g = 2 * azimuths_of_p; ///< a multiple: g turns with p
constexpr double two_pi = 2 * pi;

// The last interval of ascending nodes whose beginning is not above x, and where in it x lies.
std::pair<int, double> within(const std::vector<double>& nodes, double x) {
    const auto next = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x);
    const auto i = static_cast<std::size_t>(next - nodes.begin()) - 1;
    return {static_cast<int>(i), std::clamp((x - nodes[i]) / (nodes[i + 1] - nodes[i]), 0.0, 1.0)};
}

// Bilinear at share s between rows i and i + 1, round in `width` columns that begin at azimuth 0.
DistributionNodes::Place bilinear(int i, double s, const Vector& v, int width) {
    double turn = std::atan2(v[1], v[0]) / two_pi;
    turn = (turn < 0 ? turn + 1 : turn) * width;
    const int j = width == 1 ? 0 : std::min(static_cast<int>(turn), width - 1);
    const double t = width == 1 ? 0 : turn - j;
    const int other = (j + 1) % width;
    return {{i * width + j, i * width + other, (i + 1) * width + j, (i + 1) * width + other},
            {(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t}};
}

} // namespace

DistributionNodes::DistributionNodes(bool isotropic) {
    table_.width = isotropic ? 1 : azimuths_of_p;
    for (std::size_t j = 0; j < table_.width; ++j)
        table_.phis.push_back(two_pi * static_cast<double>(j) / static_cast<double>(table_.width));
    table_.height = isotropic ? isotropic_thetas : anisotropic_thetas;
    for (std::size_t i = 0; i < table_.height; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(table_.height - 1);
        table_.thetas.push_back(share * share * pi / 2);
    }
    grid_.sector = isotropic ? Sector::Isotropic : Sector::All;
    grid_.rows = isotropic ? 256 : 60;
    grid_.columns = isotropic ? 1 : columns_of_g;
    grid_.scale = 0.1;
    if (isotropic)
        map_isotropic();
    else
        map_anisotropic();
}

DistributionNodes::Place DistributionNodes::place_of_normal(const Vector& h) const {
    const auto [i, s] = within(table_.thetas, std::atan2(std::hypot(h[0], h[1]), h[2]));
    return bilinear(i, s, h, static_cast<int>(table_.width));
}

DistributionNodes::Place DistributionNodes::place_of_area(const Vector& k) const {
    const double row = grid_.row(std::atan2(k[2], std::hypot(k[0], k[1])));
    const int i = std::clamp(static_cast<int>(row), 0, static_cast<int>(grid_.rows) - 2);
    return bilinear(i, std::clamp(row - i, 0.0, 1.0), k, static_cast<int>(grid_.columns));
}

// Over azimuth, (a cos phi + b)+ has a closed integral.
void DistributionNodes::map_isotropic() {
    areas_ = Eigen::MatrixXd::Zero(static_cast<int>(grid_.rows), static_cast<int>(count()));
    const Quadrature rule = gauss_legendre(24);
    for (std::size_t r = 0; r < grid_.rows; ++r) {
        const double e = grid_.elevation(static_cast<double>(r));
        for (std::size_t n = 0; n + 1 < table_.height; ++n) {
            // The integrand's derivative is unbounded where its azimuths begin to be cut.
            std::vector<double> ends{table_.thetas[n], table_.thetas[n + 1]};
            if (e > ends[0] && e < ends[1])
                ends.insert(ends.begin() + 1, e);
            for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece)
                for (std::size_t i = 0; i < rule.size(); ++i) {
                    const double width = ends[piece + 1] - ends[piece];
                    const double theta = ends[piece] + width * rule.x[i];
                    const double a = std::sin(theta) * std::cos(e);
                    const double b = std::cos(theta) * std::sin(e);
                    const double over =
                        b >= a
                            ? two_pi * b
                            : 2 * (b * std::acos(-b / a) + std::sqrt(std::max(0.0, a * a - b * b)));
                    const double w = over * std::sin(theta) * width * rule.w[i];
                    const double t =
                        (theta - table_.thetas[n]) / (table_.thetas[n + 1] - table_.thetas[n]);
                    areas_(static_cast<int>(r), static_cast<int>(n)) += w * (1 - t);
                    areas_(static_cast<int>(r), static_cast<int>(n) + 1) += w * t;
                }
        }
    }
}

// By quadrature over the cells, for the columns of g up to the first azimuth of p; the others are
// these turned.
void DistributionNodes::map_anisotropic() {
    const auto width = static_cast<int>(table_.width), columns = static_cast<int>(grid_.columns);
    const int step = columns / width;
    areas_ =
        Eigen::MatrixXd::Zero(static_cast<int>(grid_.rows) * columns, static_cast<int>(count()));
    const Quadrature rule = gauss_legendre(12);
    parallel_pieces(grid_.rows, 1, [&](std::size_t begin, std::size_t) {
        const auto r = static_cast<int>(begin);
        for (int c = 0; c < step; ++c) {
            const Vector k = grid_.direction(r, c);
            for (std::size_t n = 0; n + 1 < table_.height; ++n)
                for (int j = 0; j < width; ++j)
                    for (std::size_t a = 0; a < rule.size(); ++a)
                        for (std::size_t b = 0; b < rule.size(); ++b) {
                            const double span = table_.thetas[n + 1] - table_.thetas[n];
                            const double theta = table_.thetas[n] + span * rule.x[a];
                            const double phi = two_pi * (j + rule.x[b]) / width;
                            const Vector h = direction(theta, phi);
                            const double facing = k[0] * h[0] + k[1] * h[1] + k[2] * h[2];
                            if (facing <= 0)
                                continue;
                            const double w = facing * std::sin(theta) * span * rule.w[a] * two_pi *
                                             rule.w[b] / width;
                            const auto [at, share] =
                                bilinear(static_cast<int>(n), rule.x[a], h, width);
                            for (std::size_t q = 0; q < 4; ++q)
                                areas_(r * columns + c, at[q]) += w * share[q];
                        }
        }
        for (int c = step; c < columns; ++c)
            for (int n = 0; n < static_cast<int>(count()); ++n) {
                const int j = n % width;
                areas_(r * columns + c, n - j + (j + c / step) % width) =
                    areas_(r * columns + c % step, n);
            }
    });
}

Distribution DistributionNodes::distribution(const std::vector<double>& p) const {
    auto table = std::make_shared<DirectionTable>(table_);
    const double most = *std::max_element(p.begin(), p.end());
    for (const double value : p)
        table->values.push_back(static_cast<float>(value / most));
    DistributionPart part;
    part.shape = Shape::Tabulated;
    part.table = table;
    Distribution distribution;
    distribution.parts = {part};
    distribution.sector = grid_.sector;
    distribution.name = "recovered from measurements";
    return distribution;
}

} // namespace brdfit

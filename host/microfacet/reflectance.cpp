#include "host/microfacet/reflectance.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit {

namespace {

/// What cubic interpolation between the nodes of a plane may be off by: four nodes two steps apart
/// are off by 16 times as much at the node between them; half of that gain is kept back.
std::vector<double> interpolation_errors(const Grid& grid, const std::vector<float>& plane) {
    constexpr double gain = 8;
    const auto rows = static_cast<std::ptrdiff_t>(grid.rows),
               columns = static_cast<std::ptrdiff_t>(grid.columns);
    const auto off = [](double before, double a, double own, double b, double after) {
        return std::abs((9 * (a + b) - before - after) / 16 - own) / gain;
    };
    const auto value = [&](std::ptrdiff_t r, std::ptrdiff_t k) {
        return double{plane[static_cast<std::size_t>(r) * grid.columns + folded(grid, k)]};
    };
    std::vector<double> errors;
    for (std::ptrdiff_t r = 0; r < rows; ++r) {
        // Where the grid ends, as at the last node that has neighbours.
        const std::ptrdiff_t at = rows < 7 ? -1 : std::clamp<std::ptrdiff_t>(r, 3, rows - 4);
        for (std::ptrdiff_t k = 0; k < columns; ++k) {
            double error = at < 0 ? std::abs(value(rows - 1, k) - value(0, k))
                                  : off(value(at - 3, k), value(at - 1, k), value(at, k),
                                        value(at + 1, k), value(at + 3, k));
            if (columns > 1)
                error += off(value(r, k - 3), value(r, k - 1), value(r, k), value(r, k + 1),
                             value(r, k + 3));
            errors.push_back(error);
        }
    }
    return errors;
}

} // namespace

TableReflectance::TableReflectance(const MicrofacetTable& table, double f0, bool correlated)
    : grid_(table.grid) {
    const std::vector<float>&r0 = table.reflectance(0, correlated),
          &r1 = table.reflectance(1, correlated);
    for (std::size_t i = 0; i < r0.size(); ++i)
        reflectance_.push_back(static_cast<float>((1 - f0) * double{r0[i]} + f0 * double{r1[i]}));
    const auto [areas, leans] = interpolated_area(table);
    const std::vector<double> of_r = interpolation_errors(grid_, reflectance_),
                              of_g = interpolation_errors(grid_, areas);
    for (std::size_t i = 0; i < of_r.size(); ++i) {
        // g of the viewer and, alike, of the light.
        const double relative = 2 * of_g[i] / (leans ? 1 : std::max(double{table.g[i]}, 1e-30));
        errors_.push_back(static_cast<float>(of_r[i] + double{reflectance_[i]} * relative));
    }
}

double TableReflectance::at(const Vector& k) const {
    const double elevation = std::atan2(k[2], std::hypot(k[0], k[1]));
    return std::max(0.0, interpolate(grid_, reflectance_, grid_.row(elevation),
                                     grid_.column(std::atan2(k[1], k[0]))));
}

double TableReflectance::interpolation_error(const Vector& k) const {
    const double row = grid_.row(std::atan2(k[2], std::hypot(k[0], k[1])));
    const auto r = static_cast<std::size_t>(row);
    const auto column = static_cast<std::ptrdiff_t>(grid_.column(std::atan2(k[1], k[0])));
    double most = 0;
    for (const std::size_t i : {r, std::min(r + 1, grid_.rows - 1)})
        for (const std::ptrdiff_t j : {column, column + 1})
            most = std::max(
                most,
                double{errors_[i * grid_.columns + (grid_.columns > 1 ? folded(grid_, j) : 0)]});
    return most;
}

} // namespace brdfit

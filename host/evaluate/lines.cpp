#include "host/evaluate/lines.hpp"

#include <cmath>

namespace brdfit {

namespace {

/// What rounding left above the horizon lies on it: BRDFs grow without bound there.
Vector off_rounding(Vector v) {
    if (std::abs(v[2]) < 1e-12)
        v[2] = 0;
    return v;
}

} // namespace

std::pair<Vector, Vector> half_pair(double theta_h, double theta_d) {
    const double ahead = std::cos(theta_d), aside = std::sin(theta_d);
    const Vector h = off_rounding(direction(theta_h, 0));
    return {{ahead * h[0], aside, ahead * h[2]}, {ahead * h[0], -aside, ahead * h[2]}};
}

Line incidence_line(double theta_i, std::size_t steps_a_degree) {
    const std::size_t count = 180 * steps_a_degree + 1;
    Line line{{}, Directions(count)};
    for (std::size_t k = 0; k < count; ++k) {
        const double theta = static_cast<double>(k) / static_cast<double>(steps_a_degree) - 90;
        line.x.push_back(theta);
        line.directions.set(k, off_rounding(direction(theta_i * degree, pi)),
                            off_rounding(direction(std::abs(theta) * degree, theta < 0 ? pi : 0)));
    }
    return line;
}

Line half_line(double theta_d, std::size_t steps_a_degree) {
    const std::size_t count = 90 * steps_a_degree + 1;
    Line line{{}, Directions(count)};
    for (std::size_t k = 0; k < count; ++k) {
        line.x.push_back(static_cast<double>(k) / static_cast<double>(steps_a_degree));
        const auto [wi, wo] = half_pair(line.x.back() * degree, theta_d * degree);
        line.directions.set(k, wi, wo);
    }
    return line;
}

} // namespace brdfit

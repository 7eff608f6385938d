#include "tests/support/hemisphere.hpp"

#include "host/quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit::test {

namespace {

constexpr std::size_t rows = 24, columns = 48, deepest = 18;
const Quadrature rule = gauss_legendre(4);

} // namespace

Hemisphere::Hemisphere(const OnHemisphere& function, double tolerance,
                       const std::vector<Vector>& hints) {
    for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < columns; ++j)
            nodes_.push_back({pi / 2 * static_cast<double>(i) / rows,
                              2 * pi * static_cast<double>(j) / columns, 2 * pi / columns,
                              pi / 2 / rows});
    evaluate(function, 0);
    std::vector<std::size_t> open(nodes_.size());
    for (std::size_t i = 0; i < open.size(); ++i)
        open[i] = i;
    for (std::size_t depth = 0; depth < deepest && !open.empty(); ++depth) {
        std::vector<std::size_t> held(nodes_.size());
        for (const Vector& hint : hints)
            ++held[leaf_of(hint)];
        const std::size_t begin = nodes_.size();
        for (const std::size_t i : open) {
            const Node node = nodes_[i];
            nodes_[i].children = nodes_.size();
            for (const double down : {0.0, 0.5})
                for (const double right : {0.0, 0.5})
                    nodes_.push_back({node.theta + down * node.height,
                                      node.phi + right * node.width, node.width / 2,
                                      node.height / 2});
        }
        evaluate(function, begin);
        std::vector<std::size_t> next;
        for (const std::size_t i : open) {
            double sum = 0;
            for (std::size_t c = 0; c < 4; ++c)
                sum += nodes_[nodes_[i].children + c].integral;
            // Kernels give 1e-5.
            if (std::abs(sum - nodes_[i].integral) > tolerance + 2e-5 * sum ||
                held[i] > hints.size() / 2048)
                for (std::size_t c = 0; c < 4; ++c)
                    next.push_back(nodes_[i].children + c);
        }
        open = std::move(next);
    }
}

void Hemisphere::evaluate(const OnHemisphere& function, std::size_t begin) {
    std::vector<Vector> points;
    for (std::size_t i = begin; i < nodes_.size(); ++i)
        for (const double u : rule.x)
            for (const double v : rule.x)
                points.push_back(direction(nodes_[i].theta + u * nodes_[i].height,
                                           nodes_[i].phi + v * nodes_[i].width));
    const std::vector<double> values = function(points);
    std::size_t k = 0;
    for (std::size_t i = begin; i < nodes_.size(); ++i)
        for (std::size_t u = 0; u < rule.size(); ++u)
            for (std::size_t v = 0; v < rule.size(); ++v, ++k)
                nodes_[i].integral += values[k] * rule.w[u] * rule.w[v] * nodes_[i].height *
                                      nodes_[i].width *
                                      std::sin(nodes_[i].theta + rule.x[u] * nodes_[i].height);
}

std::size_t Hemisphere::leaf_of(const Vector& w) const {
    const double theta = std::atan2(std::hypot(w[0], w[1]), w[2]);
    double phi = std::atan2(w[1], w[0]);
    phi += phi < 0 ? 2 * pi : 0;
    const auto part = [](double x, std::size_t parts) {
        return std::min(static_cast<std::size_t>(x * static_cast<double>(parts)), parts - 1);
    };
    std::size_t i = part(theta / (pi / 2), rows) * columns + part(phi / (2 * pi), columns);
    while (nodes_[i].children != 0) {
        const Node& n = nodes_[i];
        i = n.children + (theta >= n.theta + n.height / 2 ? 2 : 0) +
            (phi >= n.phi + n.width / 2 ? 1 : 0);
    }
    return i;
}

double Hemisphere::integral() const {
    double sum = 0;
    for (const Node& node : nodes_)
        if (node.children == 0)
            sum += node.integral;
    return sum;
}

std::vector<Hemisphere::Leaf> Hemisphere::count(const std::vector<Vector>& directions) const {
    std::vector<std::size_t> counts(nodes_.size());
    for (const Vector& w : directions)
        ++counts[leaf_of(w)];
    std::vector<Leaf> leaves;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
        if (nodes_[i].children == 0)
            leaves.push_back({nodes_[i].integral, counts[i]});
    return leaves;
}

} // namespace brdfit::test

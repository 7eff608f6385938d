#include "host/evaluate/grid.hpp"

#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace brdfit {

namespace {

constexpr std::size_t pairs_a_piece = 16384;

/// Two neighbouring nodes and the second one's share.
struct Between {
    std::array<std::size_t, 2> node;
    double share;

    double weight(std::size_t i) const { return i == 0 ? 1 - share : share; }
};

/// Among `count` nodes at whole numbers, constant beyond the ends.
Between between(double at, std::size_t count) {
    const double inside = std::min(std::max(at, 0.0), static_cast<double>(count - 1));
    const std::size_t node = std::min(static_cast<std::size_t>(inside), count - 2);
    return {{node, node + 1}, inside - static_cast<double>(node)};
}

/// The same where the first node follows on the last.
Between between_periodic(double at, std::size_t count) {
    const double turns = static_cast<double>(count);
    const double inside = at - std::floor(at / turns) * turns;
    const std::size_t node = static_cast<std::size_t>(inside) % count;
    return {{node, (node + 1) % count}, inside - std::floor(inside)};
}

/// Calls nodes(wi, wo, add) for each pair above the horizon, where add(node, weight) takes the
/// samples that the pair lies between.
template <typename Nodes>
std::vector<float> interpolate(const Samples& samples, const Directions& directions, Nodes nodes,
                               const ProgressFunction& progress) {
    const std::size_t count = directions.count(), channels = samples.channels.size();
    std::vector<float> values(channels * count);
    const auto piece = [&](std::size_t begin, std::size_t end) {
        std::vector<double> sum(channels);
        for (std::size_t k = begin; k < end; ++k) {
            if (!directions.above_horizon(k))
                continue;
            std::fill(sum.begin(), sum.end(), 0);
            double all = 0;
            const auto [wi, wo] = directions.pair(k);
            nodes(wi, wo, [&](std::size_t node, double weight) {
                if (samples.valid[node] == 0)
                    return;
                all += weight;
                for (std::size_t c = 0; c < channels; ++c)
                    sum[c] += weight * samples.channel(c)[node];
            });
            for (std::size_t c = 0; c < channels; ++c)
                values[c * count + k] = static_cast<float>(all > 0 ? sum[c] / all : 0);
        }
    };
    parallel_pieces(count, pairs_a_piece, piece, progress);
    return values;
}

} // namespace

std::vector<float> evaluate_merl(const Samples& samples, const Directions& directions,
                                 const ProgressFunction& progress) {
    const auto nodes = [](const Vector& wi, const Vector& wo, const auto& add) {
        const auto at = merl::bin_coordinates(wi, wo);
        const Between h = between(at[0] - 0.5, merl::theta_h_bins);
        const Between d = between(at[1] - 0.5, merl::theta_d_bins);
        const Between p = between_periodic(at[2] - 0.5, merl::phi_d_bins);
        for (std::size_t i = 0; i < 8; ++i) {
            const std::size_t a = i / 4, b = i / 2 % 2, c = i % 2;
            add((h.node[a] * merl::theta_d_bins + d.node[b]) * merl::phi_d_bins + p.node[c],
                h.weight(a) * d.weight(b) * p.weight(c));
        }
    };
    return interpolate(samples, directions, nodes, progress);
}

std::vector<float> evaluate_utia(const Samples& samples, const Directions& directions,
                                 const ProgressFunction& progress) {
    const auto theta = [](const Vector& w) {
        return between(std::atan2(std::hypot(w[0], w[1]), w[2]) / utia::theta_step,
                       utia::theta_nodes);
    };
    const auto phi = [](const Vector& w) {
        return between_periodic(std::atan2(w[1], w[0]) / utia::phi_step, utia::phi_nodes);
    };
    const auto nodes = [&](const Vector& wi, const Vector& wo, const auto& add) {
        const Between theta_i = theta(wi), phi_i = phi(wi), theta_o = theta(wo), phi_o = phi(wo);
        for (std::size_t i = 0; i < 16; ++i) {
            const std::size_t a = i / 8, b = i / 4 % 2, c = i / 2 % 2, d = i % 2;
            add((theta_i.node[a] * utia::phi_nodes + phi_i.node[b]) * utia::directions +
                    theta_o.node[c] * utia::phi_nodes + phi_o.node[d],
                theta_i.weight(a) * phi_i.weight(b) * theta_o.weight(c) * phi_o.weight(d));
        }
    };
    return interpolate(samples, directions, nodes, progress);
}

} // namespace brdfit

#include "host/measured/rows.hpp"

#include <fmt/format.h>

namespace brdfit {

std::vector<std::string> numbered_channels(std::size_t n) {
    if (n == 3)
        return {"R", "G", "B"};
    std::vector<std::string> names;
    for (std::size_t c = 0; c < n; ++c)
        names.push_back(fmt::format("channel_{}", c + 1));
    return names;
}

std::vector<std::pair<double, double>> ranges_of(const std::vector<double>& nodes, double begin,
                                                 double end) {
    std::vector<std::pair<double, double>> ranges;
    for (std::size_t i = 0; i < nodes.size(); ++i)
        ranges.emplace_back(i == 0 ? begin : (nodes[i - 1] + nodes[i]) / 2,
                            i + 1 == nodes.size() ? end : (nodes[i] + nodes[i + 1]) / 2);
    return ranges;
}

Samples Rows::samples(std::string format, bool isotropic) {
    const std::size_t count = pairs_.size(), channels = channels_.size();
    Samples samples;
    samples.format = std::move(format);
    samples.channels = std::move(channels_);
    samples.isotropic = isotropic;
    samples.weights = std::move(weights_);
    samples.valid = std::move(valid_);
    samples.values.resize(count * channels);
    Directions directions(count);
    for (std::size_t k = 0; k < count; ++k) {
        directions.set(k, pairs_[k].first, pairs_[k].second);
        samples.valid[k] &= static_cast<std::uint8_t>(directions.above_horizon(k));
        for (std::size_t c = 0; c < channels; ++c)
            samples.values[c * count + k] = values_[k * channels + c];
    }
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    return samples;
}

} // namespace brdfit

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

namespace {

constexpr const char* written_meanwhile =
    "has other rows than when it was opened; expected no other process to write it";

} // namespace

Rows::Rows(const text::Lines& lines, std::vector<std::string> channels, std::size_t count,
           bool weighted)
    : lines_(lines), directions_(Directions::unfilled(count)) {
    samples_.channels = std::move(channels);
    samples_.values.resize(count * samples_.channels.size());
    samples_.weights.resize(weighted ? count : 0);
    samples_.valid.resize(count);
}

void Rows::add(const Vector& wi, const Vector& wo, bool valid) {
    if (added_ == directions_.count())
        lines_.fail_file(written_meanwhile);
    row_ = added_++;
    channel_ = 0;
    directions_.set(row_, wi, wo);
    samples_.valid[row_] = valid && directions_.above_horizon(row_) ? 1 : 0;
}

Samples Rows::samples(std::string format, bool isotropic) {
    if (added_ != directions_.count())
        lines_.fail_file(written_meanwhile);
    samples_.format = std::move(format);
    samples_.isotropic = isotropic;
    samples_.directions = std::make_shared<const Directions>(std::move(directions_));
    return std::move(samples_);
}

} // namespace brdfit

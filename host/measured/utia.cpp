#include "host/error.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/rows.hpp"

#include <cfloat>
#include <cmath>
#include <cstring>
#include <fmt/format.h>

namespace brdfit::utia {

namespace {

constexpr std::size_t file_bytes = channels * directions * directions * sizeof(double);

} // namespace

Vector node_direction(std::size_t node) {
    return direction(static_cast<double>(node / phi_nodes) * theta_step,
                     static_cast<double>(node % phi_nodes) * phi_step);
}

bool recognise(std::string_view bytes) {
    return bytes.size() == file_bytes;
}

std::vector<float> read_table(const MappedFile& file) {
    if (file.bytes().size() != file_bytes)
        throw InputError(fmt::format("{}: the file has {} bytes; expected {}", file.path(),
                                     file.bytes().size(), file_bytes));
    std::vector<float> table(channels * directions * directions);
    for (std::size_t k = 0; k < table.size(); ++k) {
        double value;
        std::memcpy(&value, file.bytes().data() + k * sizeof value, sizeof value);
        if (!(std::abs(value) <= FLT_MAX))
            throw InputError(fmt::format("{}: byte {}: {}; expected a finite number", file.path(),
                                         k * sizeof value, value));
        table[k] = static_cast<float>(value);
    }
    return table;
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    Samples samples;
    samples.values = read_table(file);
    samples.format = "UTIA binary";
    samples.channels = numbered_channels(channels);
    samples.isotropic = isotropic.value_or(false);
    std::vector<double> theta, measure;
    for (std::size_t i = 0; i < theta_nodes; ++i)
        theta.push_back(static_cast<double>(i) * theta_step);
    for (const auto& [least, most] : ranges_of(theta, 0, theta.back() + theta_step / 2))
        measure.push_back((std::cos(least) - std::cos(most)) * phi_step);
    const std::size_t count = directions * directions;
    Directions pairs = Directions::unfilled(count);
    samples.weights.reserve(count);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = k / directions, o = k % directions;
        pairs.set(k, node_direction(i), node_direction(o));
        samples.weights.push_back(
            static_cast<float>(measure[i / phi_nodes] * measure[o / phi_nodes]));
    }
    samples.directions = std::make_shared<const Directions>(std::move(pairs));
    samples.valid.assign(count, 1);
    return samples;
}

} // namespace brdfit::utia

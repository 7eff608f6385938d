#pragma once

#include "host/measured/samples.hpp"

#include <string>
#include <utility>
#include <vector>

// What readers of formats that give one row after the other share.

namespace brdfit {

/// Names of n channels that a format does not name: R, G, B or channel_1 and so on.
std::vector<std::string> numbered_channels(std::size_t n);

/// Where on a line each of ascending nodes is the nearest, from `begin` to `end`.
std::vector<std::pair<double, double>> ranges_of(const std::vector<double>& nodes, double begin,
                                                 double end);

/// Collects samples, whose number shows at the end.
class Rows {
  public:
    explicit Rows(std::vector<std::string> channels) : channels_(std::move(channels)) {}

    /// A sample; its values follow, one a channel. `wi` and `wo`: unit vectors.
    void add(const Vector& wi, const Vector& wo, bool valid = true) {
        pairs_.emplace_back(wi, wo);
        valid_.push_back(valid);
    }
    void add_value(float value) { values_.push_back(value); }
    void add_weight(float weight) { weights_.push_back(weight); }
    bool empty() const { return pairs_.empty(); }

    /// All of them. Samples below the horizon become invalid.
    Samples samples(std::string format, bool isotropic);

  private:
    std::vector<std::string> channels_;
    std::vector<std::pair<Vector, Vector>> pairs_;
    std::vector<float> values_; // [sample][channel]
    std::vector<float> weights_;
    std::vector<std::uint8_t> valid_;
};

} // namespace brdfit

#pragma once

#include "host/files/text.hpp"
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

/// Collects samples of a text. Their number must be known, so that each goes where it stays; a text
/// that has another in the end is an InputError: some other process writes it.
class Rows {
  public:
    /// `lines` outlives this.
    Rows(const text::Lines& lines, std::vector<std::string> channels, std::size_t count,
         bool weighted = false);

    /// The next sample; its values follow, one a channel. `wi` and `wo`: unit vectors. Below the
    /// horizon it is not valid.
    void add(const Vector& wi, const Vector& wo, bool valid = true);
    void add_value(float value) {
        samples_.values[channel_++ * directions_.count() + row_] = value;
    }
    void add_weight(float weight) { samples_.weights[row_] = weight; }

    /// All of them, when each is there.
    Samples samples(std::string format, bool isotropic);

  private:
    const text::Lines& lines_;
    Samples samples_;
    Directions directions_;
    std::size_t added_ = 0, row_ = 0, channel_ = 0; // the value that comes next
};

} // namespace brdfit

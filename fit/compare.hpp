#pragma once

#include "fit/metric.hpp"
#include "host/device/device.hpp"
#include "host/evaluate/brdf.hpp"
#include "host/files/json.hpp"
#include "host/measured/samples.hpp"
#include "host/progress.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace brdfit {

/// Two BRDFs at the same pairs of directions, in the channels that both have.
struct ComparedValues {
    Samples a;            ///< A's values; weights and validity of the measured one
    std::vector<float> b; ///< B's, [channel][sample]
    std::string at;       ///< where, for people
};

/// The grid that two materials are compared on: the centres of MERL's bins, with their weights.
/// `turned`: each pair is turned about the normal, pair k by k golden sections of a turn, so that
/// all azimuths have their share; for comparisons with what is anisotropic.
std::shared_ptr<const Directions> comparison_directions(bool turned);

/// Evaluates A and B at the samples of A where it is measured, otherwise at B's, otherwise on the
/// grid of comparison_directions. Samples of an isotropic measurement are turned likewise where the
/// other is anisotropic. Channels are those of the same name; one channel each goes together
/// whatever the names. Throws InputError where no channel is common.
ComparedValues values_to_compare(const Device& device, const Brdf& a, const Brdf& b,
                                 const std::string& name_a, const std::string& name_b,
                                 const ProgressFunction& progress = {});

/// Of all samples compared, or of those in a band of an angle.
struct Difference {
    std::size_t samples = 0;
    MetricErrors errors{}; ///< of B, A being the data
    double bias = 0;       ///< sum of w iz (b - a) / sum of w iz |a|; NaN where the latter is 0
    double share = 0;      ///< of all the squared error `ngan`
    /// Of sum |b - a| / sum |a| over channels, of the samples where A is not 0; NaN where none is.
    double median = 0, high = 0, largest = 0; ///< high: the 95th percentile
    std::size_t zeros = 0;                    ///< samples where A is 0 in all channels
};

struct Band {
    double from, to; ///< degrees
    Difference difference;
};

/// A pair of directions at which A and B differ.
struct WorstSample {
    std::uint32_t sample;
    double theta_i, phi_i, theta_o, phi_o, theta_h, theta_d; ///< degrees
    double difference; ///< iz |b - a|, the root of the mean square over channels
    double relative;   ///< as in Difference; infinite where A is 0
};

struct Comparison {
    Difference all;
    std::vector<Band> theta_i, theta_h, theta_d; ///< those with samples
    std::vector<WorstSample> worst;              ///< by `difference`, the largest first
    WorstSample largest_relative;                ///< of the samples where A is not 0
};

/// Compares at the valid samples with both directions within max_theta degrees. Throws InputError
/// where there is none.
Comparison compare(const ComparedValues& values, double max_theta, std::size_t worst);

/// All of it for programs; what is no finite number is null.
Json comparison_json(const Comparison& comparison, const ComparedValues& values, double max_theta);

/// Nodes of a map's axes, [0, 90] degrees: theta_h in even steps of its square root.
inline constexpr std::size_t map_cells = 45;

/// The bias of cells over theta_h and theta_d, [theta_d][theta_h], NaN where there are no samples.
struct DifferenceMap {
    std::vector<double> theta_h, theta_d; ///< edges of cells, degrees
    std::vector<double> bias;
};
DifferenceMap difference_map(const ComparedValues& values, double max_theta);

} // namespace brdfit

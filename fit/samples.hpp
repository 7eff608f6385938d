#pragma once

#include "fit/metric.hpp"
#include "host/device/device.hpp"
#include "host/measured/samples.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace brdfit {

/// The samples a fit uses: the valid ones with theta_i, theta_o <= max_theta, packed and padded on
/// the device. What depends on the models is added by Objective.
struct DeviceSamples {
    std::size_t count = 0;  ///< samples used
    std::size_t stride = 0; ///< padded to a vector for each work-item of a group
    std::size_t groups = 0; ///< blocks; the last may be shorter
    int channels = 0;
    int chunk = 0;  ///< channels a sums pass handles at once
    int chunks = 0; ///< passes; values are padded to chunk * chunks channels
    bool isotropic = true;
    /// Squared errors are sums / (count * channels): weights are scaled to a mean of 1.
    double norm() const { return static_cast<double>(count) * channels; }

    std::size_t pairs = 0; ///< of the file's directions
    cl::Buffer directions; ///< the file's, [plane][pair]
    cl::Buffer index;      ///< [stride] into the pairs; the padding repeats the last
    cl::Buffer values; ///< of the channels, in the order of VALUE_AT of kernels/passes/prepare.cl
    /// W that makes W (f - y)^2 the metric, or where it is not quadratic in f resemble it near y: w
    /// iz^2 (ngan), iz^2 (l2), w iz^2 times the mean over channels of phi'(iz y)^2 (log, cbrt); 0
    /// in the padding.
    cl::Buffer weights;
    cl::Buffer solid_angle; ///< w, mean 1
    cl::Buffer iz;          ///< cosine of wi

    std::vector<std::uint32_t> used; ///< the samples' numbers in the file
};

/// The valid samples with both directions above the horizon and within max_theta degrees, in order.
/// Throws InputError, naming the file, where there is none.
std::vector<std::uint32_t> used_samples(const Samples& samples, double max_theta_degrees);

/// Packs the samples. Throws InputError, naming the file, where none is left, and where a buffer is
/// larger than the device allows.
DeviceSamples pack_samples(const Device& device, const Samples& samples, double max_theta_degrees,
                           Metric metric);
/// The same samples for another metric: what does not depend on it is shared.
DeviceSamples packed_for(Metric metric, const Device& device, const Samples& samples,
                         const DeviceSamples& packed);
/// About `count` of the packed samples, one of each run of equal length, for the global search. The
/// same on every machine. All of them where there are not more.
DeviceSamples thin_samples(const Device& device, const Samples& samples,
                           const DeviceSamples& packed, Metric metric, std::size_t count);

} // namespace brdfit

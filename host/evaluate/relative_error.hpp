#pragma once

#include <cstddef>
#include <vector>

namespace brdfit {

/// Relative errors of many values: in the median and at the 95th percentile.
struct RelativeError {
    double median = 0, high = 0;
};

/// Of values, [channel][k], against as many expected ones. A value's error is relative to the
/// expected one, or to a thousandth of its channel's mean where that is more.
RelativeError relative_error(const std::vector<float>& values, const std::vector<float>& expected,
                             std::size_t channels);

} // namespace brdfit

#include "host/evaluate/relative_error.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit {

RelativeError relative_error(const std::vector<float>& values, const std::vector<float>& expected,
                             std::size_t channels) {
    const std::size_t count = expected.size() / channels;
    std::vector<double> errors;
    errors.reserve(expected.size());
    for (std::size_t ch = 0; ch < channels; ++ch) {
        const float* const f = expected.data() + ch * count;
        double mean = 0;
        for (std::size_t k = 0; k < count; ++k)
            mean += std::abs(static_cast<double>(f[k])) / static_cast<double>(count);
        for (std::size_t k = 0; k < count; ++k) {
            const double scale = std::max(std::abs(static_cast<double>(f[k])), 1e-3 * mean);
            errors.push_back(scale > 0 ? std::abs(values[ch * count + k] - f[k]) / scale : 0);
        }
    }
    if (errors.empty())
        return {};
    const auto quantile = [&](double share) {
        const auto at = errors.begin() +
                        static_cast<std::ptrdiff_t>(share * static_cast<double>(errors.size() - 1));
        std::nth_element(errors.begin(), at, errors.end());
        return *at;
    };
    const double median = quantile(0.5);
    return {median, quantile(0.95)};
}

} // namespace brdfit

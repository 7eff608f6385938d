#pragma once

#include <algorithm>
#include <cmath>

namespace brdfit {

/// Linear light of an sRGB value in [0, 1], IEC 61966-2-1.
inline float linear_of_srgb(float srgb) {
    const double s = srgb;
    return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

/// The sRGB value in [0, 1] of linear light; what is outside of 0 to 1 is cut off, what is no
/// number black.
inline double srgb_of_linear(float light) {
    const double x = light > 0 ? std::min(double{light}, 1.0) : 0;
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

} // namespace brdfit

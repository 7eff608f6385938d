#pragma once

#include "host/image/image.hpp"

#include <array>
#include <vector>

namespace brdfit {

/// Throws UsageError where pictures are not of one size, or one has no channel R, G or B.
void require_rgb_of_one_size(const Image& a, const Image& b);

/// `scale` times the absolute difference of R, G, B; what else `a` has is kept. Throws like
/// require_rgb_of_one_size.
Image difference(const Image& a, const Image& b, double scale);

/// Peak signal-to-noise ratio in dB, 10 log10(1 / mean squared difference), of R, G, B as a screen
/// shows them (sRGB values in [0, 1], so that the peak is 1) and of the three together. Infinite
/// where pictures are equal. Both as linear light in [0, 1]; throws like
/// require_rgb_of_one_size.
struct Psnr {
    std::array<double, 3> channels;
    double all;
};
Psnr psnr(const Image& a, const Image& b);

/// Pixels a degree of visual angle of a screen 0.7 m wide with 3840 pixels, seen from 0.7 m: what
/// FLIP's authors assume.
inline constexpr double flip_pixels_a_degree = 67.0206432765;

/// What people see of the difference when they alternate between two pictures, [pixel], 0 to 1:
/// FLIP by Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A
/// Difference Evaluator for Alternating Images", with its constants. Both as linear light in [0,
/// 1]; throws like require_rgb_of_one_size.
std::vector<float> flip(const Image& reference, const Image& test,
                        double pixels_a_degree = flip_pixels_a_degree);

} // namespace brdfit

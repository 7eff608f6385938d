// How pictures differ: PSNR and FLIP, against values of the authors' own program
// (flip-evaluator 1.7) for a picture that is written down here.

#include "host/error.hpp"
#include "host/image/difference.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

namespace {

using namespace brdfit;
using namespace brdfit::test;

constexpr std::size_t side = 48;

Image filled(float r, float g, float b) {
    Image image;
    image.width = image.height = side;
    image.channels = {"R", "G", "B"};
    for (const float value : {r, g, b})
        image.planes.emplace_back(side * side, value);
    return image;
}

Image ramps_over_checks() {
    Image image = filled(0, 0, 0);
    for (std::size_t y = 0; y < side; ++y)
        for (std::size_t x = 0; x < side; ++x) {
            const std::size_t i = y * side + x;
            image.planes[0][i] = static_cast<float>(x) / (side - 1);
            image.planes[1][i] = static_cast<float>(y) / (side - 1);
            image.planes[2][i] = (x / 6 + y / 6) % 2 == 1 ? 0.9F : 0.1F;
        }
    return image;
}

/// A block of another colour, a band that is a little greener, and a white dot.
Image spoilt(Image image) {
    for (std::size_t y = 10; y < 20; ++y)
        for (std::size_t x = 10; x < 30; ++x) {
            image.planes[0][y * side + x] = 0.9F;
            image.planes[1][y * side + x] = 0.2F;
            image.planes[2][y * side + x] = 0.1F;
        }
    for (std::size_t y = 30; y < 40; ++y)
        for (std::size_t x = 5; x < 45; ++x)
            image.planes[1][y * side + x] = std::min(1.0F, image.planes[1][y * side + x] + 0.1F);
    for (std::vector<float>& plane : image.planes)
        plane[5 * side + 40] = 1;
    return image;
}

double mean(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(Flip, is_what_its_authors_compute) {
    const Image reference = ramps_over_checks();
    const std::vector<float> map = flip(reference, spoilt(reference));
    EXPECT_NEAR(mean(map), 0.180727, 5e-4);
    struct Check {
        std::size_t y, x;
        double value;
    };
    for (const Check& check : {Check{15, 20, 0.820521},
                               {5, 40, 0.414223},
                               {35, 20, 0.366067},
                               {29, 20, 0.235418},
                               {20, 31, 0.190677},
                               {8, 40, 0.037433}})
        EXPECT_NEAR(map[check.y * side + check.x], check.value, 2e-3) << check.x << ", " << check.y;
}

// Green and blue are the colours farthest apart: what the scale ends at.
TEST(Flip, goes_from_0_to_1) {
    EXPECT_NEAR(mean(flip(filled(0, 1, 0), filled(0, 0, 1))), 1, 1e-4);
    EXPECT_NEAR(mean(flip(filled(0, 0, 0), filled(1, 1, 1))), 0.967392, 1e-4);
    const Image reference = ramps_over_checks();
    for (const float value : flip(reference, reference))
        EXPECT_NEAR(value, 0, 1e-4);
}

TEST(PeakSignalToNoise, is_that_of_a_known_difference) {
    const Psnr found = psnr(filled(0, 1, 1), filled(1, 1, 1));
    EXPECT_NEAR(found.channels[0], 0, 1e-12);
    EXPECT_TRUE(std::isinf(found.channels[1]));
    EXPECT_NEAR(found.all, 10 * std::log10(3.0), 1e-12);
    // sRGB of 0.21404114 is 0.5.
    EXPECT_NEAR(psnr(filled(0.21404114F, 0, 0), filled(0, 0, 0)).channels[0], 20 * std::log10(2.0),
                1e-5);
}

TEST(Differences, are_of_pictures_of_one_size) {
    Image small = filled(0, 0, 0);
    small.width /= 2;
    for (std::vector<float>& plane : small.planes)
        plane.resize(small.width * small.height);
    const auto refused = [](const auto& action) { return complaint<UsageError>(action); };
    EXPECT_NE(refused([&] { psnr(filled(0, 0, 0), small); }).find("48 x 48 and 24 x 48"),
              std::string::npos);
    EXPECT_NE(refused([&] { flip(small, filled(0, 0, 0)); }), "");
    Image grey = filled(0, 0, 0);
    grey.channels[1] = "Y";
    EXPECT_NE(refused([&] { psnr(grey, grey); }).find("channel G"), std::string::npos);
}

} // namespace

// Fits of real measurements that are unlike a dense isotropic RGB grid: three angles of incidence,
// retro-reflection, values below 0, weights, hundreds of channels.

#include "fit/structures.hpp"
#include "host/measured/read.hpp"
#include "tests/support/fits.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace brdfit::test {

namespace {

class RealFits : public testing::Test {
  protected:
    void SetUp() override {
        if (data_folder().empty())
            GTEST_SKIP() << "BRDFIT_DATA is not set";
    }
    static Samples read(const char* file) { return read_samples((data_folder() / file).string()); }
    static double error(const FitResult& result) { return error_of(result, Metric::Ngan); }
};

} // namespace

TEST_F(RealFits, three_incidences_of_a_retro_reflector_need_a_lobe_that_turns_back) {
    for (const char* file : {"alta/retro-3M-jaune.dat", "alta/retro-gray-tape.dat"}) {
        SCOPED_TRACE(file);
        const Samples samples = read(file);
        const FitResult back = fit(samples, "lafortune"), forth = fit(samples, "ggx"),
                        both = fit(samples, "lafortune+ggx");
        EXPECT_NEAR(back.theta.at(0), 1, 0.01); // C
        EXPECT_GT(back.theta.at(1), 100);       // n
        EXPECT_LT(error(back), 0.99 * error(forth));
        EXPECT_NEAR(both.theta.at(0), 1, 0.01);
        EXPECT_LT(error(both), error(back));
    }
    // What is measured at three angles may be anything between them, unless it conserves energy.
    FitOptions options;
    options.conserve = true;
    const FitResult conserving = fit(read("alta/retro-gray-tape.dat"), "lafortune", 1, options);
    EXPECT_NEAR(conserving.theta.at(0), 1, 0.01);
    EXPECT_LE(conserving.largest_albedo.value, 1 + conserved_tolerance);
}

TEST_F(RealFits, values_below_0_are_fitted_as_they_are) {
    for (const char* file : {"cornell/krylon_blue_RGB.astm", "rgl/chm_orange_rgb.bsdf"}) {
        SCOPED_TRACE(file);
        Samples samples = read(file);
        const auto below = [](float y) { return y < 0; };
        ASSERT_GT(std::count_if(samples.values.begin(), samples.values.end(), below), 20);
        const FitResult kept = fit(samples, "kurt");
        const MetricErrors expected = reference_errors(kept.material, samples);
        for (std::size_t i = 0; i < metric_count; ++i)
            EXPECT_NEAR(kept.errors[i], expected[i], 1e-3 * expected[i]) << i;
        std::size_t used = 0;
        const double lowest = std::cos(80 * degree);
        for (std::size_t k = 0; k < samples.count(); ++k)
            used += samples.valid[k] != 0 && samples.directions->wi(k)[2] >= lowest &&
                    samples.directions->wo(k)[2] >= lowest;
        EXPECT_EQ(kept.samples, used);
        // Raised to 0 they are other data.
        for (float& y : samples.values)
            y = std::max(y, 0.0F);
        EXPECT_NE(fit(samples, "kurt").material.kd, kept.material.kd);
    }
}

TEST_F(RealFits, samples_count_by_their_weights) {
    Samples samples = read("ua-loft/processed__zemax__AnoBlackEC1onAlum.bsdf");
    ASSERT_EQ(samples.weights.size(), samples.count());
    const FitResult weighted = fit(samples, "ggx");
    EXPECT_NEAR(error(weighted), reference_errors(weighted.material, samples)[0],
                1e-3 * error(weighted));
    // The minimum of this error and of no other.
    const std::vector<float> weights = std::exchange(samples.weights, {});
    const FitResult even = fit(samples, "ggx");
    samples.weights = weights;
    EXPECT_LT(error(weighted), 0.999 * reference_errors(even.material, samples)[0]);
    // A scale changes nothing.
    for (float& weight : samples.weights)
        weight *= 16;
    EXPECT_EQ(fit(samples, "ggx").theta, weighted.theta);
}

TEST_F(RealFits, hundreds_of_channels_are_fitted_like_a_few) {
    const Samples few = read("cornell/garnet_red.brdf");
    ASSERT_EQ(few.channels.size(), 31U);
    Samples many = few;
    for (int copy = 1; copy < 8; ++copy)
        for (std::size_t ch = 0; ch < 31; ++ch) {
            many.channels.push_back(fmt::format("{}_{}", few.channels[ch], copy));
            many.values.insert(many.values.end(), few.channel(ch), few.channel(ch) + few.count());
        }
    const FitResult a = fit(few, "ggx"), b = fit(many, "ggx");
    EXPECT_NEAR(error(a), error(b), 1e-5 * error(a));
    ASSERT_EQ(b.material.kd.size(), 248U);
    for (std::size_t p = 0; p < a.theta.size(); ++p)
        EXPECT_NEAR(a.theta[p], b.theta[p], 1e-3 * std::max(a.theta[p], 0.01)) << p;
    for (std::size_t ch = 0; ch < 31; ++ch)
        EXPECT_NEAR(b.material.kd[ch], b.material.kd[217 + ch], 1e-6);
}

} // namespace brdfit::test

#include "tests/support/chi_square.hpp"

#include "tests/support/support.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace brdfit::test {

namespace {} // namespace

std::vector<Vector> above(const DirectionSamples& samples) {
    std::vector<Vector> directions;
    for (std::size_t k = 0; k < samples.count(); ++k)
        if (samples.wi_z[k] > 0)
            directions.push_back({samples.wi_x[k], samples.wi_y[k], samples.wi_z[k]});
    return directions;
}

std::vector<Vector> hints_of(std::vector<Vector> directions, std::size_t most) {
    directions.resize(std::min(directions.size(), most));
    return directions;
}

Hemisphere density_cells(const Sampler& sampler, const Vector& wo,
                         const std::vector<Vector>& hints) {
    return {[&](const std::vector<Vector>& wi) {
                Directions directions(wi.size());
                for (std::size_t k = 0; k < wi.size(); ++k)
                    directions.set(k, wi[k], wo);
                const std::vector<float> values = sampler.density(directions);
                return std::vector<double>(values.begin(), values.end());
            },
            2e-7, hints};
}

double deviation(double chi2, double degrees) {
    return (std::cbrt(chi2 / degrees) - (1 - 2 / (9 * degrees))) / std::sqrt(2 / (9 * degrees));
}

void expect_distribution(const Hemisphere& cells, const std::vector<Vector>& above,
                         std::size_t total) {
    constexpr double least = 200; // samples a bin
    const double n = static_cast<double>(total);
    double chi2 = 0, bins = 0, expected = 0, counted = 0;
    const auto close = [&] {
        chi2 += (counted - expected) * (counted - expected) / expected;
        ++bins;
        expected = counted = 0;
    };
    for (const Hemisphere::Leaf& leaf : cells.count(above)) {
        expected += n * leaf.integral;
        counted += static_cast<double>(leaf.count);
        if (expected >= least)
            close();
    }
    // What is left with what is below the horizon.
    expected += n * (1 - cells.integral());
    counted += n - static_cast<double>(above.size());
    if (expected >= least)
        close();
    ASSERT_GE(bins, 20);
    EXPECT_LT(deviation(chi2, bins - 1), far_off) << chi2 << " in " << bins << " bins";
}

void expect_samples_follow_density(const Material& material, std::size_t total) {
    const Sampler sampler(device(), material);
    for (const double theta : {0.0, 40.0, 80.0, 89.5}) {
        SCOPED_TRACE(fmt::format("{} from {} degrees", to_json(material)["lobes"].dump(), theta));
        const Vector wo = direction(theta * degree, 0.4);
        const DirectionSamples samples = sampler.sample(wo, total, 7, Sequence::Philox);
        const std::vector<Vector> kept = above(samples);
        const Hemisphere cells = density_cells(sampler, wo, hints_of(kept));
        const double share = static_cast<double>(kept.size()) / static_cast<double>(total);
        EXPECT_LE(cells.integral(), 1 + 2e-4);
        EXPECT_NEAR(cells.integral(), share,
                    2e-4 + far_off * std::sqrt(share * (1 - share) / static_cast<double>(total)));
        expect_distribution(cells, kept, total);
        for (std::size_t k = 0; k < samples.count(); ++k) {
            const bool rejected = !(samples.wi_z[k] > 0);
            ASSERT_TRUE(std::isfinite(samples.weights[k]) && samples.weights[k] >= 0) << k;
            ASSERT_EQ(samples.pdf[k] == 0, rejected) << k;
            ASSERT_TRUE(!rejected || samples.weights[k] == 0) << k;
            ASSERT_NEAR(std::hypot(samples.wi_x[k], samples.wi_y[k], samples.wi_z[k]), 1, 1e-5);
        }
    }
}

} // namespace brdfit::test

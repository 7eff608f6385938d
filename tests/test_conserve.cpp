// Materials that reflect no more than they receive: the largest albedo of a fit, albedos as limits
// of kd and ks, and fits that conserve energy.

#include "fit/structures.hpp"
#include "host/albedo/material.hpp"
#include "tests/support/fits.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <memory>
#include <tuple>

namespace brdfit {

namespace {

using test::device;
using test::error_of;
using test::fit;
using test::measured;
using test::programs;
using test::test_name;
using test::typical_material;

/// A material whose largest R up to 80 degrees is 1.3, in its second channel.
Material bright(const Structure& structure) {
    Material material = typical_material(structure);
    for (Lobe& lobe : material.lobes) {
        lobe.ks = {0.4, 1.5, 0.8};
        if (lobe.model->name == "kurt")
            lobe.theta.back() = 0.5; // alpha
    }
    const std::vector<double> r = albedo(device(), material, AlbedoGrid{10, 1}, 1e-2).values[1];
    const double scale = 1.3 / *std::max_element(r.begin(), r.end() - 1);
    for (Lobe& lobe : material.lobes)
        for (double& ks : lobe.ks)
            ks *= scale;
    for (double& kd : material.kd)
        kd *= scale;
    return material;
}

/// The largest R of any channel up to 89 degrees, by the albedo command's integrals.
double largest_up_to_89(const Material& material, bool isotropic) {
    const AlbedoGrid grid{91, isotropic ? std::size_t{1} : std::size_t{4}};
    double largest = 0;
    for (const std::vector<double>& values : albedo(device(), material, grid, 5e-4).values)
        for (std::size_t k = 0; k < values.size(); ++k)
            if (k % 91 <= 89)
                largest = std::max(largest, values[k]);
    return largest;
}

TEST(LargestAlbedo, is_that_of_the_albedo_integrator_and_above_1_where_the_material_is) {
    for (const char* name : {"kurt", "kurt-coupled", "ward"})
        for (const bool isotropic : {true, false}) {
            SCOPED_TRACE(fmt::format("{} {}", name, isotropic));
            const Structure structure = structure_named(name, 1, "", isotropic);
            Material truth = typical_material(structure);
            truth.lobes[0].ks = {0.2, 1.5, 0.4};
            if (truth.lobes[0].model->name == "kurt")
                truth.lobes[0].theta.back() = 0.5; // alpha
            const FitResult result = fit(measured(truth, 20000, 0), structure);
            const AlbedoGrid grid{91, isotropic ? std::size_t{1} : std::size_t{4}};
            const Albedo expected = albedo(device(), result.material, grid, 1e-3);
            double largest = 0;
            for (const std::vector<double>& values : expected.values)
                for (std::size_t k = 0; k < values.size(); ++k)
                    if (k % 91 <= 85)
                        largest = std::max(largest, values[k]);
            const LargestAlbedo& found = result.largest_albedo;
            EXPECT_NEAR(found.value, largest, 0.02 * std::max(1.0, largest));
            EXPECT_EQ(found.channel, result.material.channels[1]);
            EXPECT_EQ(found.above_1(), largest > 1.01);
        }
}

class Limit : public testing::TestWithParam<std::string> {
  protected:
    Limit() : structure(structure_named(GetParam(), 1, "", true)), truth(bright(structure)) {}
    Structure structure;
    Material truth;
};

INSTANTIATE_TEST_SUITE_P(Conserve, Limit, testing::ValuesIn(test::fitted_model_names()), test_name);

TEST_P(Limit, gradients_are_those_of_differences) {
    const Samples samples = measured(truth, 3000, 0.02);
    for (const Metric metric : {Metric::Ngan, Metric::Log, Metric::Cbrt}) {
        const DeviceSamples packed = pack_samples(device(), samples, 80, metric);
        Objective objective(device(), programs().get(structure, packed.channels, packed.chunk),
                            packed);
        const auto limit = std::make_shared<AlbedoLimit>(
            AlbedoLimit{ComponentAlbedos(programs(), structure),
                        viewers_at({0, 40, 70, 85}, structure, 3, {}), 8192});
        const auto error = [&](const std::vector<double>& theta, std::vector<double>* gradient) {
            Coefficients a;
            return quadratic(metric) ? objective.projected_error(theta, gradient)
                                     : objective.projected_loss(metric, theta, a, gradient);
        };
        std::vector<double> theta = truth.lobes[0].theta;
        for (double& t : theta)
            t *= 0.97; // lafortune has a kink at its C
        const double free = error(theta, nullptr);
        objective.limit_albedos(limit);
        std::vector<double> gradient;
        const double limited = error(theta, &gradient);
        EXPECT_GT(limited, 1.05 * free) << name_of(metric); // else nothing is tried
        double steepest = 0;
        std::vector<double> slopes;
        for (std::size_t p = 0; p < theta.size(); ++p) {
            const double step = 2e-3 * std::max(0.2, std::abs(theta[p]));
            std::vector<double> t = theta;
            t[p] = theta[p] + step;
            const double above = error(t, nullptr);
            t[p] = theta[p] - step;
            slopes.push_back((above - error(t, nullptr)) / (2 * step));
            steepest = std::max(steepest, std::abs(slopes[p] * theta[p]));
        }
        for (std::size_t p = 0; p < theta.size(); ++p)
            EXPECT_NEAR(gradient[p] * theta[p], slopes[p] * theta[p], 0.02 * steepest)
                << name_of(metric) << ", parameter " << p;
    }
}

FitOptions conserving() {
    FitOptions options;
    options.conserve = true;
    return options;
}

TEST_P(Limit, fits_conserve_energy_and_no_random_start_is_better) {
    const Samples samples = measured(truth, 5000, 0.02);
    const FitResult free = fit(samples, structure);
    FitOptions options = conserving();
    options.random_starts = 2;
    const FitResult result = fit(samples, structure, options);
    const double largest = largest_up_to_89(result.material, true);
    EXPECT_LT(largest, 1 + conserved_tolerance);
    EXPECT_NEAR(result.largest_albedo.value, largest, 1e-3);
    EXPECT_GT(largest, 0.99); // kept down no more than it takes
    EXPECT_GE(error_of(result, Metric::Ngan), error_of(free, Metric::Ngan));
    EXPECT_EQ(result.random_starts_better, 0);
}

TEST(Conserve, fits_of_every_form_and_metric_conserve_energy) {
    for (const auto& [name, lobes, isotropic, metric] : {std::tuple("kurt", 1, true, Metric::Log),
                                                         {"ggx", 1, false, Metric::Cbrt},
                                                         {"kurt-coupled", 1, true, Metric::Ngan},
                                                         {"cook-torrance", 2, false, Metric::L2}}) {
        SCOPED_TRACE(fmt::format("{} {} {}", name, lobes, isotropic));
        const Structure structure = structure_named(name, lobes, "", isotropic);
        FitOptions options = conserving();
        options.metric = metric;
        const FitResult result = fit(measured(bright(structure), 2000), structure, options);
        EXPECT_LT(largest_up_to_89(result.material, isotropic), 1 + conserved_tolerance);
    }
}

TEST(Conserve, what_conserves_energy_freely_stays_as_it_is) {
    const Structure structure = structure_named("cook-torrance", 1, "", true);
    const Samples samples = measured(typical_material(structure), 3000);
    const FitResult free = fit(samples, structure), result = fit(samples, structure, conserving());
    ASSERT_LT(free.largest_albedo.value, 0.95);
    EXPECT_EQ(result.theta, free.theta);
    EXPECT_EQ(result.material.kd, free.material.kd);
}

// Both fits are kept within the limit, so the larger one has what the smaller one has and more.
TEST(Conserve, a_second_lobe_is_never_worse) {
    for (const char* name : {"cook-torrance", "ward-duer"}) {
        const Structure one = structure_named(name, 1, "", true),
                        two = structure_named(name, 2, "", true);
        const Samples samples = measured(bright(one), 1000);
        EXPECT_LE(error_of(fit(samples, two, conserving()), Metric::Ngan),
                  error_of(fit(samples, one, conserving()), Metric::Ngan) * (1 + 1e-4))
            << name;
    }
}

} // namespace

} // namespace brdfit

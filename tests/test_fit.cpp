// What a fit owes its user: it recovers what made the data, reports the errors of what it wrote,
// minimises what it was asked to, and knows how sure it is.

#include "fit/structures.hpp"
#include "host/albedo/material.hpp"
#include "host/error.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

namespace brdfit {

namespace {

using test::device;
using test::error_of;
using test::fit;
using test::measured;
using test::test_name;
using test::typical_material;

constexpr Metric metrics[] = {Metric::Ngan, Metric::L2, Metric::Log, Metric::Cbrt};

/// The parameters within 1 % of the truth; those that may be 0 in the middle of their use (alpha)
/// within 0.02.
void expect_recovered(const Material& found, const Material& truth) {
    ASSERT_EQ(found.lobes.size(), truth.lobes.size());
    EXPECT_EQ(found.diffuse, truth.diffuse);
    for (std::size_t ch = 0; ch < truth.kd.size(); ++ch)
        EXPECT_NEAR(found.kd[ch], truth.kd[ch], 0.01 * truth.kd[ch]) << "kd " << ch;
    for (std::size_t l = 0; l < truth.lobes.size(); ++l) {
        const Lobe& lobe = truth.lobes[l];
        ASSERT_EQ(found.lobes[l].model, lobe.model);
        ASSERT_EQ(found.lobes[l].isotropic, lobe.isotropic);
        const std::vector<Parameter>& parameters = lobe.model->parameters(lobe.isotropic);
        for (std::size_t i = 0; i < parameters.size(); ++i) {
            const double tolerance =
                parameters[i].name == "alpha" ? 0.02 : 0.01 * std::abs(lobe.theta[i]);
            EXPECT_NEAR(found.lobes[l].theta[i], lobe.theta[i], tolerance)
                << "lobe " << l << ", " << parameters[i].name;
        }
        for (std::size_t ch = 0; ch < lobe.ks.size(); ++ch)
            EXPECT_NEAR(found.lobes[l].ks[ch], lobe.ks[ch], 0.01 * lobe.ks[ch])
                << "lobe " << l << ", ks " << ch;
    }
}

class EveryModel : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Fit, EveryModel, testing::ValuesIn(test::all_model_names()), test_name);

TEST_P(EveryModel, is_recovered_from_noisy_data_on_merls_grid) {
    const Structure structure = structure_named(GetParam(), 1, "", true);
    const Material truth = typical_material(structure);
    const Samples samples = synthesise_merl(device(), truth, 0.02, 1, "truth");
    const FitResult result = fit(samples, structure);
    EXPECT_EQ(result.model, GetParam());
    expect_recovered(result.material, truth);
    for (const FittedParameter& parameter : result.parameters)
        EXPECT_FALSE(parameter.at_bound) << parameter.name;
}

TEST_P(EveryModel, is_recovered_from_noisy_anisotropic_data) {
    const Structure structure = structure_named(GetParam(), 1, "", false);
    const Material truth = typical_material(structure);
    Samples samples = synthesise(device(), truth, random_directions(100000, false, 2), 0.02, 3);
    EXPECT_FALSE(samples.isotropic);
    expect_recovered(fit(samples, structure).material, truth);
}

TEST_P(EveryModel, is_recovered_from_a_start_far_away) {
    const Structure structure = structure_named(GetParam(), 1, "", true);
    const Material truth = typical_material(structure);
    const Samples samples = measured(truth, 50000);
    // Roughness a fifth and five times the truth's, the others at the ends of their ranges.
    for (const bool high : {false, true}) {
        FitOptions options;
        options.start = truth;
        for (Lobe& lobe : options.start->lobes) {
            const std::vector<Parameter>& parameters = lobe.model->parameters(true);
            for (std::size_t i = 0; i < parameters.size(); ++i) {
                const Parameter& p = parameters[i];
                if (!p.width())
                    lobe.theta[i] = high ? p.upper : p.lower;
                else
                    lobe.theta[i] *= high ? 5.0 : 0.2;
            }
        }
        SCOPED_TRACE(high ? "from above" : "from below");
        expect_recovered(fit(samples, structure, options).material, truth);
    }
}

TEST(Recovery, mixture_of_two_models) {
    for (const bool isotropic : {true, false}) {
        const Structure structure = structure_named("kurt+ashikhmin-shirley", 1, "", isotropic);
        Material truth = typical_material(structure);
        truth.lobes[0].theta.back() = 0.2;
        for (std::size_t i = 1; i < truth.lobes[1].theta.size(); ++i)
            truth.lobes[1].theta[i] = 300 / static_cast<double>(i);
        for (double& ks : truth.lobes[1].ks) // its peak's noise would hide the other
            ks *= 0.05;
        SCOPED_TRACE(isotropic ? "isotropic" : "anisotropic");
        const Samples samples = isotropic ? synthesise_merl(device(), truth, 0.02, 1, "truth")
                                          : measured(truth, 200000);
        const FitResult result = fit(samples, structure);
        EXPECT_EQ(result.model, "kurt+ashikhmin-shirley");
        expect_recovered(result.material, truth);
    }
}

TEST(Recovery, two_lobes_of_one_model_the_broad_one_first) {
    const Structure structure = structure_named("ward", 2, "", true);
    Material truth = typical_material(structure);
    truth.lobes[0].theta = {0.5};
    truth.lobes[1].theta = {0.1};
    expect_recovered(fit(synthesise_merl(device(), truth, 0.02, 4, "truth"), structure).material,
                     truth);
}

TEST(Recovery, many_channels) {
    const Structure structure = structure_named("kurt", 1, "", true);
    const Material truth = typical_material(structure, 31);
    expect_recovered(fit(measured(truth, 50000), structure).material, truth);
}

TEST(Recovery, isotropic_form_is_used_for_isotropic_data) {
    const Structure structure = structure_named("ward", 1, "", true);
    const FitResult result = fit(measured(typical_material(structure), 2000), "ward");
    EXPECT_TRUE(result.material.lobes.at(0).isotropic);
    EXPECT_EQ(result.theta.size(), 1U);
}

/// A measurement that none of the models fits exactly, with weights of its own.
Samples odd_measurement(bool isotropic = true) {
    const Structure structure = structure_named("cook-torrance+ward-duer", 1, "", isotropic);
    Material material = typical_material(structure);
    material.lobes[0].theta[1] = 0.09;
    Samples samples = synthesise(device(), material, random_directions(2000, isotropic, 8), 0.1, 9);
    samples.isotropic = isotropic;
    samples.source = "odd";
    for (std::size_t k = 0; k < samples.count(); ++k) {
        samples.weights.push_back(0.25F + static_cast<float>(k % 5));
        if (k % 11 == 0)
            samples.valid[k] = 0;
        if (k % 13 == 0)
            samples.channel(1)[k] *= -0.01F; // noise about nothing is negative at times
    }
    return samples;
}

FitOptions minimising(Metric metric) {
    FitOptions options;
    options.metric = metric;
    return options;
}

class EveryLobe : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Fit, EveryLobe, testing::ValuesIn(test::fitted_model_names()), test_name);

TEST_P(EveryLobe, reported_errors_are_those_of_the_written_material) {
    const Samples samples = odd_measurement();
    const test::TemporaryFolder folder;
    for (const Metric metric : metrics) {
        const FitResult result = fit(samples, GetParam(), 1, minimising(metric));
        write_material(result.material, folder / "material.json");
        const MetricErrors expected =
            test::reference_errors(read_material(folder / "material.json"), samples);
        for (const Metric other : metrics) {
            const double e = expected[static_cast<std::size_t>(other)];
            EXPECT_NEAR(error_of(result, other), e, 1e-4 * e)
                << "minimising " << name_of(metric) << ": " << name_of(other);
        }
    }
}

TEST_P(EveryLobe, minimising_a_metric_is_best_in_that_metric) {
    const Samples samples = odd_measurement();
    for (const int lobes : {1, 2}) {
        std::vector<FitResult> results;
        for (const Metric metric : metrics)
            results.push_back(fit(samples, GetParam(), lobes, minimising(metric)));
        for (std::size_t i = 0; i < results.size(); ++i)
            for (std::size_t other = 0; other < results.size(); ++other)
                EXPECT_LE(error_of(results[i], metrics[i]),
                          error_of(results[other], metrics[i]) * (1 + 1e-4))
                    << lobes << " lobes, " << name_of(metrics[i]) << " when minimising "
                    << name_of(metrics[other]);
    }
}

TEST_P(EveryLobe, fixed_parameters_stay_and_bounds_hold) {
    const Samples samples = odd_measurement();
    const std::vector<Parameter> parameters =
        layout_of(structure_named(GetParam(), 1, "", true)).parameters;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        const Parameter& p = parameters[i];
        FitOptions fixed;
        fixed.ranges = {{p.name, 0, p.start, p.start, true}};
        const FitResult result = fit(samples, GetParam(), 1, fixed);
        EXPECT_EQ(result.theta[i], p.start) << p.name;
        EXPECT_TRUE(std::isnan(result.parameters[i].standard_error)) << p.name;
        EXPECT_FALSE(result.parameters[i].at_bound) << p.name;

        FitOptions bounded;
        const double margin = 0.1 * std::abs(p.start);
        bounded.ranges = {{p.name, 0, p.start - margin, p.start + margin, false}};
        const double value = fit(samples, GetParam(), 1, bounded).theta[i];
        EXPECT_GE(value, p.start - margin) << p.name;
        EXPECT_LE(value, p.start + margin) << p.name;
    }
}

TEST(FitOptions, samples_beyond_max_theta_are_dropped) {
    const Samples samples = odd_measurement();
    FitOptions options;
    options.max_theta = 45;
    const FitResult result = fit(samples, "ward", 1, options);
    std::size_t within = 0;
    for (std::size_t k = 0; k < samples.count(); ++k)
        within += samples.valid[k] != 0 && samples.directions->wi(k)[2] >= std::sqrt(0.5) &&
                          samples.directions->wo(k)[2] >= std::sqrt(0.5)
                      ? 1
                      : 0;
    EXPECT_EQ(result.samples, within);
    const double expected = test::reference_errors(result.material, samples, 45)[0];
    EXPECT_NEAR(error_of(result, Metric::Ngan), expected, 1e-4 * expected);
}

TEST(FitOptions, every_derivative_based_and_local_algorithm_reaches_the_default_s_optimum) {
    const Samples samples = measured(typical_material(structure_named("ward", 1, "", true)), 2000);
    const double best = error_of(fit(samples, "ward"), Metric::Ngan);
    for (const char* name : {"slsqp", "lbfgs", "mma", "tnewton", "var2", "bobyqa", "cobyla",
                             "neldermead", "sbplx", "praxis"}) {
        FitOptions options;
        options.algorithm = algorithm_named(name);
        EXPECT_NEAR(error_of(fit(samples, "ward", 1, options), Metric::Ngan), best, 1e-4 * best)
            << name;
    }
}

TEST(FitOptions, start_of_another_structure_or_out_of_bounds_is_refused) {
    const Samples samples = odd_measurement();
    FitOptions options;
    options.start = typical_material(structure_named("ward", 1, "", true));
    EXPECT_THROW(fit(samples, "ward-duer", 1, options), UsageError);
    EXPECT_THROW(fit(samples, "ward", 2, options), UsageError);
    options.ranges = {parse_bound("m=0.5:1")};
    EXPECT_THROW(fit(samples, "ward", 1, options), UsageError);
}

TEST(FitOptions, start_with_a_lobe_of_no_strength_is_searched_too) {
    const Structure both = structure_named("ward+blinn-phong", 1, "", true);
    Samples samples = measured(typical_material(structure_named("ward", 1, "", true)), 400);
    // Nothing is reflected where the second lobe is.
    for (std::size_t k = 0; k < samples.count(); ++k) {
        const Vector wi = samples.directions->wi(k), wo = samples.directions->wo(k);
        const Vector sum{wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
        if (sum[2] > 0.95 * std::hypot(sum[0], sum[1], sum[2]))
            for (std::size_t c = 0; c < samples.channels.size(); ++c)
                samples.channel(c)[k] = 0;
    }
    FitOptions options;
    options.start = typical_material(both);
    options.start->lobes[1].theta = {200};
    const FitResult result = fit(samples, both, options);
    EXPECT_GT(result.thinned_evaluations, 0U);
    for (const char* part : {"ward", "blinn-phong"})
        EXPECT_LE(error_of(result, Metric::Ngan),
                  error_of(fit(samples, part), Metric::Ngan) * (1 + 1e-6))
            << part;
}

TEST(FitOptions, same_start_gives_the_same_result_to_the_bit) {
    const Samples samples = odd_measurement();
    const FitResult a = fit(samples, "kurt", 2), b = fit(samples, "kurt", 2);
    EXPECT_EQ(a.theta, b.theta);
    EXPECT_EQ(to_json(a.material), to_json(b.material));
    EXPECT_EQ(a.errors, b.errors);
    EXPECT_EQ(a.evaluations, b.evaluations);
}

TEST(Broken, data_that_leaves_nothing_to_fit_is_refused) {
    Samples samples = odd_measurement();
    Samples invalid = samples, grazing = samples, weightless = samples;
    std::fill(invalid.valid.begin(), invalid.valid.end(), std::uint8_t{0});
    EXPECT_THROW(fit(invalid, "ward"), InputError);
    for (std::size_t k = 0; k < grazing.count(); ++k)
        if (std::min(grazing.directions->wi(k)[2], grazing.directions->wo(k)[2]) > 0.17)
            grazing.valid[k] = 0;
    EXPECT_THROW(fit(grazing, "ward"), InputError);
    std::fill(weightless.weights.begin(), weightless.weights.end(), 0.0F);
    EXPECT_THROW(fit(weightless, "ward"), InputError);
}

TEST(Broken, data_without_reflectance_fits_to_black) {
    Samples samples = odd_measurement();
    std::fill(samples.values.begin(), samples.values.end(), 0.0F);
    const FitResult result = fit(samples, "kurt", 2);
    for (std::size_t ch = 0; ch < 3; ++ch) {
        EXPECT_EQ(result.material.kd[ch], 0);
        EXPECT_EQ(result.material.lobes[0].ks[ch], 0);
        EXPECT_EQ(result.material.lobes[1].ks[ch], 0);
    }
    for (const double error : result.errors)
        EXPECT_EQ(error, 0);
}

TEST(Broken, negative_data_fits_to_black) {
    Samples samples = odd_measurement();
    for (float& value : samples.values)
        value = -std::abs(value);
    const FitResult result = fit(samples, "ward");
    EXPECT_EQ(result.material.kd, (std::vector<double>(3, 0.0)));
    EXPECT_EQ(result.material.lobes[0].ks, (std::vector<double>(3, 0.0)));
}

TEST(Broken, one_sample_can_be_fitted) {
    Samples samples = odd_measurement();
    std::size_t kept = 1;
    while (samples.directions->wi(kept)[2] < 0.5 || samples.directions->wo(kept)[2] < 0.5 ||
           kept % 13 == 0 || kept % 11 == 0)
        ++kept;
    for (std::size_t k = 0; k < samples.count(); ++k)
        samples.valid[k] = k == kept ? 1 : 0;
    const FitResult result = fit(samples, "kurt");
    EXPECT_EQ(result.samples, 1U);
    const double iz = samples.directions->wi(kept)[2];
    EXPECT_LT(error_of(result, Metric::Ngan), 1e-3 * iz * samples.channel(0)[kept]);
    for (const FittedParameter& parameter : result.parameters)
        EXPECT_TRUE(std::isnan(parameter.standard_error)) << parameter.name;
}

// Standard errors.

/// The material with errors that a fit of the metric takes for independent and of variance s^2 / w.
Samples with_uniform_errors(const Material& material, Metric metric, double s, bool weighted,
                            std::uint64_t seed) {
    Samples samples = measured(material, 400, 0);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        const double w = weighted ? 0.2 + static_cast<double>(k % 8) : 1;
        if (weighted)
            samples.weights.push_back(static_cast<float>(w));
        const double iz = samples.directions->wi(k)[2];
        const double sigma = metric == Metric::L2 ? s : s / std::sqrt(w);
        for (std::size_t ch = 0; ch < samples.channels.size(); ++ch) {
            float& y = samples.channel(ch)[k];
            const double error = sigma * normal(random);
            switch (metric) {
            case Metric::Log:
                y = static_cast<float>(std::expm1(std::log1p(iz * y) + error) / iz);
                break;
            case Metric::Cbrt:
                y = static_cast<float>(std::pow(std::cbrt(iz * y) + error, 3) / iz);
                break;
            default:
                y = static_cast<float>(y + error / iz);
            }
        }
    }
    return samples;
}

struct Scatter {
    std::vector<double> values, errors;
};

class StandardErrorsOf : public testing::TestWithParam<Metric> {};

INSTANTIATE_TEST_SUITE_P(Fit, StandardErrorsOf, testing::ValuesIn(metrics),
                         [](const auto& info) { return name_of(info.param); });

TEST_P(StandardErrorsOf, are_the_scatter_of_repeated_fits) {
    constexpr std::size_t repetitions = 30;
    const Structure structure = structure_named("kurt", 1, "", true);
    Material truth = typical_material(structure);
    truth.lobes[0].theta[2] = 0.4; // far from the bounds
    for (const bool weighted : {false, true}) {
        std::map<std::string, Scatter> scatter;
        for (std::size_t i = 0; i < repetitions; ++i) {
            const Samples samples = with_uniform_errors(truth, GetParam(), 2e-3, weighted, 100 + i);
            for (const FittedParameter& p :
                 fit(samples, structure, minimising(GetParam())).parameters) {
                ASSERT_TRUE(std::isfinite(p.standard_error)) << p.name;
                ASSERT_FALSE(p.at_bound) << p.name;
                scatter[p.name].values.push_back(p.value);
                scatter[p.name].errors.push_back(p.standard_error);
            }
        }
        EXPECT_EQ(scatter.size(), 9U);
        for (const auto& [name, s] : scatter) {
            const double count = repetitions;
            double mean = 0, variance = 0, error = 0;
            for (const double value : s.values)
                mean += value / count;
            for (const double value : s.values)
                variance += (value - mean) * (value - mean) / (count - 1);
            for (const double e : s.errors)
                error += e / count;
            const double ratio = error / std::sqrt(variance);
            EXPECT_GT(ratio, 1 / 1.5) << name << (weighted ? ", weighted" : "");
            EXPECT_LT(ratio, 1.5) << name << (weighted ? ", weighted" : "");
        }
    }
}

TEST_P(StandardErrorsOf, are_missing_and_flagged_at_bounds) {
    const Structure structure = structure_named("kurt", 1, "", true);
    Material truth = typical_material(structure);
    truth.lobes[0].theta[2] = 0.4;
    truth.kd[1] = 0;
    Samples samples = measured(truth, 1000, 0);
    for (std::size_t k = 0; k < samples.count(); ++k)
        samples.channel(1)[k] -= 1e-3F; // so that kd of this channel wants to be negative
    FitOptions options = minimising(GetParam());
    options.ranges = {parse_bound("alpha=0:0.39"), parse_fix("f0=0.5")};
    const FitResult result = fit(samples, structure, options);
    for (const FittedParameter& p : result.parameters) {
        const bool bound = p.name == "lobes[0].alpha" || p.name == "kd[c1]";
        EXPECT_EQ(p.at_bound, bound) << p.name << " = " << p.value;
        EXPECT_EQ(std::isnan(p.standard_error), bound || p.name == "lobes[0].f0") << p.name;
    }
    EXPECT_NEAR(result.theta[2], 0.39, 1e-6);
    EXPECT_EQ(result.material.kd[1], 0);
}

TEST(StandardErrors, are_missing_where_the_data_does_not_tell) {
    // All of the data at one angle between the directions: F is one number, and so is its product
    // with ks.
    const Structure structure = structure_named("kurt-plausible", 1, "", true);
    const Material truth = typical_material(structure);
    auto directions = std::make_shared<Directions>(200);
    for (std::size_t k = 0; k < directions->count(); ++k) {
        const double tilt = 0.6 * (static_cast<double>(k) / 199 - 0.5);
        directions->set(k, direction(std::abs(0.5 + tilt), 0), direction(std::abs(0.5 - tilt), pi));
    }
    Samples samples = synthesise(device(), truth, directions, 0.01, 1);
    FitOptions options;
    options.start = truth; // every f0 is as good: a search may end at a bound, which tells ks
    const FitResult result = fit(samples, structure, options);
    for (const FittedParameter& p : result.parameters)
        EXPECT_EQ(std::isnan(p.standard_error),
                  p.name == "lobes[0].f0" || p.name.find("ks") != std::string::npos)
            << p.name << " = " << p.value << " +- " << p.standard_error;
}

// At f0 = 1 of its first lobe a coupled diffuse shape vanishes and no kd is the best.
TEST(Coupled, a_bound_on_the_second_lobe_leaves_the_first_below_1) {
    const Structure structure = structure_named("kurt-coupled", 2, "", true);
    Material truth = typical_material(structure_named("kurt", 2, "", true));
    truth.kd.assign(truth.kd.size(), 0);
    truth.lobes[0].theta[0] = truth.lobes[1].theta[0] = 1; // a mirror's F: the data wants it
    const Samples samples = measured(truth, 1000, 0);
    for (const char* bound : {"", "2.f0=0:1", "2.f0=0:0.5"}) {
        FitOptions options;
        if (*bound != '\0')
            options.ranges = {parse_bound(bound)};
        const FitResult result = fit(samples, structure, options);
        EXPECT_LT(result.theta[0], 1) << bound;
    }
    // What is asked for holds.
    FitOptions options;
    options.ranges = {parse_fix("1.f0=0.25")};
    EXPECT_EQ(fit(samples, structure, options).theta[0], 0.25);
}

} // namespace

} // namespace brdfit

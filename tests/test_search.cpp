// A fit finds the best optimum there is: no random start finds a better one, and whatever contains
// something else is never worse than it.

#include "tests/support/fits.hpp"
#include "tests/support/support.hpp"

#include "fit/structures.hpp"
#include "host/measured/read.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>

namespace brdfit {

namespace {

using test::error_of;
using test::fit;
using test::fitted_model_names;
using test::measured;
using test::test_name;
using test::typical_material;

constexpr int starts = 20;
/// What float32 sums may make of two equal errors.
constexpr double rounding = 1 + 1e-5;

/// A measurement that no single lobe fits: two lobes of models unlike each other, and noise.
Samples synthesised(bool isotropic = true) {
    const Structure structure =
        structure_named("cook-torrance+ashikhmin-shirley", 1, "", isotropic);
    Material material = typical_material(structure);
    material.lobes[0].theta[1] = 0.35;
    for (std::size_t i = 1; i < material.lobes[1].theta.size(); ++i)
        material.lobes[1].theta[i] = 400.0 / static_cast<double>(i);
    Samples samples = measured(material, 1500, 0.05, 11);
    samples.isotropic = isotropic;
    return samples;
}

/// The measurement of that name, once for all tests.
const Samples& measurement(const std::string& name) {
    static std::map<std::string, Samples> known;
    const auto found = known.find(name);
    if (found != known.end())
        return found->second;
    Samples samples = name.empty()
                          ? synthesised()
                          : read_samples((test::data_folder() / "cornell" / name).string());
    return known.emplace(name, std::move(samples)).first->second;
}

void expect_no_start_beats_the_search(const Samples& samples, const std::string& model, int lobes,
                                      Metric metric = Metric::Ngan) {
    FitOptions options;
    options.random_starts = starts;
    options.metric = metric;
    const FitResult result = fit(samples, model, lobes, options);
    EXPECT_EQ(result.random_starts_better, 0)
        << samples.source << ": " << model << " " << lobes << ", " << name_of(metric)
        << ", best error " << error_of(result, metric);
}

class EveryLobe : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Search, EveryLobe, testing::ValuesIn(fitted_model_names()), test_name);

TEST_P(EveryLobe, no_random_start_beats_the_search_on_synthesised_data) {
    for (const int lobes : {1, 2})
        expect_no_start_beats_the_search(measurement(""), GetParam(), lobes);
}

TEST_P(EveryLobe, no_random_start_beats_the_search_in_the_other_metrics) {
    for (const Metric metric : {Metric::L2, Metric::Log, Metric::Cbrt})
        expect_no_start_beats_the_search(measurement(""), GetParam(), 1, metric);
}

TEST_P(EveryLobe, no_random_start_beats_the_search_on_anisotropic_data) {
    const Samples samples = synthesised(false);
    for (const int lobes : {1, 2})
        expect_no_start_beats_the_search(samples, GetParam(), lobes);
}

TEST_P(EveryLobe, no_random_start_beats_the_search_on_real_measurements) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* file : {"garnet_red_RGB.astm", "krylon_blue_RGB.astm"})
        for (const int lobes : {1, 2})
            expect_no_start_beats_the_search(measurement(file), GetParam(), lobes);
}

TEST_P(EveryLobe, no_random_start_beats_the_search_on_real_spectral_measurements) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* file :
         {"acryl_blue.brdf", "cayman.brdf", "garnet_red.brdf", "krylon_blue.brdf"})
        for (const int lobes : {1, 2})
            expect_no_start_beats_the_search(measurement(file), GetParam(), lobes);
}

TEST(RandomStarts, find_what_a_fit_stopped_short_of) {
    FitOptions options;
    options.start = typical_material(structure_named("kurt", 1, "", true));
    options.max_evaluations = 2;
    const FitResult stopped = fit(measurement(""), "kurt", 1, options);
    options.random_starts = starts;
    const FitResult found = fit(measurement(""), "kurt", 1, options);
    const double best = error_of(fit(measurement(""), "kurt", 1), Metric::Ngan);
    EXPECT_GT(error_of(stopped, Metric::Ngan), best * 1.01);
    EXPECT_GT(found.random_starts_better, 0);
    EXPECT_LE(error_of(found, Metric::Ngan), best * rounding);
    EXPECT_GT(found.thinned_evaluations, stopped.thinned_evaluations);
}

TEST_P(EveryLobe, more_lobes_are_never_worse) {
    for (const Metric metric : {Metric::Ngan, Metric::L2, Metric::Log, Metric::Cbrt}) {
        FitOptions options;
        options.metric = metric;
        double before = error_of(fit(measurement(""), "lambert", 1, options), metric);
        for (const int lobes : {1, 2, 3}) {
            if (lobes > 2 && metric != Metric::Ngan)
                continue; // takes long, and goes the same way
            const double error = error_of(fit(measurement(""), GetParam(), lobes, options), metric);
            EXPECT_LE(error, before * rounding) << lobes << " lobes, " << name_of(metric);
            before = error;
        }
    }
}

TEST_P(EveryLobe, more_lobes_are_never_worse_on_real_measurements) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* file : {"garnet_red_RGB.astm", "krylon_blue_RGB.astm"}) {
        const double one = error_of(fit(measurement(file), GetParam(), 1), Metric::Ngan);
        EXPECT_LE(error_of(fit(measurement(file), GetParam(), 2), Metric::Ngan), one * rounding)
            << file;
    }
}

TEST_P(EveryLobe, is_never_worse_than_itself_with_a_parameter_fixed_or_bounded) {
    const Samples& samples = measurement("");
    for (const int lobes : {1, 2}) {
        const double free = error_of(fit(samples, GetParam(), lobes), Metric::Ngan);
        for (const Parameter& p : layout_of(structure_named(GetParam(), 1, "", true)).parameters) {
            FitOptions options;
            for (const double value : {p.start, p.start / 3}) {
                options.ranges = {{p.name, 0, value, value, true}};
                EXPECT_LE(free, error_of(fit(samples, GetParam(), lobes, options), Metric::Ngan) *
                                    rounding)
                    << lobes << " lobes, " << p.name << " = " << value;
            }
            options.ranges = {{p.name, lobes, p.start,
                               std::min(p.upper, p.start + 0.5 * std::abs(p.start)), false}};
            EXPECT_LE(free,
                      error_of(fit(samples, GetParam(), lobes, options), Metric::Ngan) * rounding)
                << lobes << " lobes, " << p.name << " bounded";
        }
    }
}

TEST_P(EveryLobe, anisotropic_form_is_never_worse_than_the_isotropic) {
    Samples samples = synthesised(false);
    for (const int lobes : {1, 2}) {
        samples.isotropic = true;
        const double isotropic = error_of(fit(samples, GetParam(), lobes), Metric::Ngan);
        samples.isotropic = false;
        EXPECT_LE(error_of(fit(samples, GetParam(), lobes), Metric::Ngan), isotropic * rounding)
            << lobes << " lobes";
    }
}

TEST(Mixture, is_never_worse_than_either_of_its_models) {
    // Each model once on each side.
    std::vector<std::string> models;
    for (const Model& model : catalogue())
        if (model.kind == Kind::Lobe)
            models.push_back(model.name);
    for (std::size_t i = 0; i < models.size(); ++i) {
        const std::string &a = models[i], &b = models[(i + 1) % models.size()];
        const double mixed = error_of(fit(measurement(""), a + "+" + b), Metric::Ngan);
        EXPECT_LE(mixed, error_of(fit(measurement(""), a), Metric::Ngan) * rounding)
            << a << "+" << b;
        EXPECT_LE(mixed, error_of(fit(measurement(""), b), Metric::Ngan) * rounding)
            << a << "+" << b;
    }
}

TEST(Mixture, no_random_start_beats_the_search) {
    for (const char* models : {"kurt+ward", "cook-torrance+ashikhmin-shirley", "ward+blinn-phong"})
        expect_no_start_beats_the_search(measurement(""), models, 1);
}

TEST(Search, fitting_other_models_before_changes_nothing) {
    const Samples& samples = measurement("");
    const auto structure = [](const char* model, int lobes) {
        return structure_named(model, lobes, "", true);
    };
    FileFitter fitter(test::device(), test::programs(), samples, {});
    fitter.fit(structure("ward", 1));
    fitter.fit(structure("kurt", 2));
    EXPECT_EQ(fitter.fit(structure("kurt", 1)).theta, fit(samples, "kurt", 1).theta);
    EXPECT_EQ(fitter.fit(structure("ward", 2)).theta, fit(samples, "ward", 2).theta);
}

} // namespace

} // namespace brdfit

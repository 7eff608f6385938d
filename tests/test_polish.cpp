// How starts are led to optima: the Levenberg-Marquardt method by itself, and on the errors of
// fits, where NLopt says whether it got there.

#include "fit/levenberg_marquardt.hpp"
#include "fit/minimise.hpp"
#include "fit/polish.hpp"
#include "fit/structures.hpp"
#include "tests/support/fits.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace brdfit {

namespace {

using test::device;
using test::measured;
using test::typical_material;
using Point = std::vector<double>;

/// The sum of squares of residuals with their derivatives, Gauss-Newton's curvature with it.
Expansion expansion_of(const Eigen::VectorXd& residuals, const Eigen::MatrixXd& by_x) {
    return {residuals.squaredNorm(), 2 * by_x.transpose() * residuals, 2 * by_x.transpose() * by_x};
}

/// Decay at two rates of data that decays at none: far from small residuals.
Expansion misfit(const Point& x) {
    constexpr int count = 40;
    Eigen::VectorXd residuals(count);
    Eigen::MatrixXd by_x(count, 2);
    for (int i = 0; i < count; ++i) {
        const double t = 0.1 * i, y = 1 / (1 + t * t) + 0.3 * std::sin(5 * t);
        const double a = std::exp(-std::exp(x[0]) * t), b = 0.5 * std::exp(-std::exp(x[1]) * t);
        residuals[i] = a + b - y;
        by_x(i, 0) = -std::exp(x[0]) * t * a;
        by_x(i, 1) = -std::exp(x[1]) * t * b;
    }
    return expansion_of(residuals, by_x);
}

Expansion rosenbrock(const Point& x) {
    Eigen::Vector2d residuals(10 * (x[1] - x[0] * x[0]), 1 - x[0]);
    Eigen::Matrix2d by_x;
    by_x << -20 * x[0], 10, -1, 0;
    return expansion_of(residuals, by_x);
}

Minimum by_nlopt(const ExpandedFunction& function, const Point& start, const Point& lower,
                 const Point& upper) {
    const Function plain = [&](const Point& x, Point* gradient) {
        const Expansion at = function(x);
        if (gradient != nullptr)
            gradient->assign(at.gradient.data(), at.gradient.data() + at.gradient.size());
        return at.value;
    };
    MinimiseOptions options;
    options.relative_tolerance = 1e-14;
    options.max_evaluations = 2000;
    return minimise(plain, start, lower, upper, options);
}

TEST(LevenbergMarquardt, reaches_the_end_of_a_bent_valley) {
    const Minimum minimum = levenberg_marquardt(rosenbrock, {-1.2, 1}, {-2, -2}, {2, 2}, {});
    EXPECT_NEAR(minimum.x[0], 1, 1e-6);
    EXPECT_NEAR(minimum.x[1], 1, 1e-6);
    EXPECT_LT(minimum.evaluations, 60);
}

TEST(LevenbergMarquardt, needs_few_evaluations_where_residuals_are_large) {
    const Minimum minimum = levenberg_marquardt(misfit, {0, -1}, {-5, -5}, {3, 3}, {});
    const Minimum expected = by_nlopt(misfit, {0, -1}, {-5, -5}, {3, 3});
    EXPECT_GT(expected.value, 0.1);
    EXPECT_LE(minimum.value, expected.value * (1 + 1e-8));
    EXPECT_LT(minimum.evaluations, 12);
}

TEST(LevenbergMarquardt, meets_nlopt_on_random_boxes_and_starts) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int trial = 0; trial < 200; ++trial) {
        const Eigen::Index n = 1 + trial % 6;
        Eigen::MatrixXd by_x(n + 3, n);
        Eigen::VectorXd residuals(n + 3);
        for (Eigen::Index i = 0; i < residuals.size(); ++i) {
            residuals[i] = normal(random);
            for (Eigen::Index k = 0; k < n; ++k)
                by_x(i, k) = normal(random) + 2; // columns that resemble each other
        }
        const ExpandedFunction linear = [&](const Point& x) {
            const Eigen::Map<const Eigen::VectorXd> at(x.data(), n);
            return expansion_of(residuals + by_x * at, by_x);
        };
        Point lower, upper, start;
        for (Eigen::Index k = 0; k < n; ++k) {
            lower.push_back(uniform(random) - 0.5);
            upper.push_back(lower.back() + (k == 2 ? 0 : 0.4));
            start.push_back(trial % 2 == 0 ? lower.back() : 0.5 * (lower.back() + upper.back()));
        }
        const Minimum minimum = levenberg_marquardt(linear, start, lower, upper, {});
        EXPECT_LE(minimum.value, by_nlopt(linear, start, lower, upper).value * (1 + 1e-8)) << trial;
        EXPECT_LE(minimum.evaluations, 3) << trial; // the model is exact
        for (std::size_t k = 0; k < start.size(); ++k) {
            EXPECT_GE(minimum.x[k], lower[k]);
            EXPECT_LE(minimum.x[k], upper[k]);
        }
    }
}

TEST(LevenbergMarquardt, leaves_a_parameter_without_effect_where_it_is) {
    const ExpandedFunction function = [](const Point& x) {
        Eigen::MatrixXd by_x = Eigen::MatrixXd::Zero(2, 2);
        by_x(0, 0) = std::exp(x[0]);
        by_x(1, 0) = 1;
        return expansion_of(Eigen::Vector2d(std::exp(x[0]) - 3, x[0] + 1), by_x);
    };
    const Minimum minimum = levenberg_marquardt(function, {-2, 0.25}, {-4, -1}, {4, 1}, {});
    EXPECT_EQ(minimum.x[1], 0.25);
    EXPECT_LE(minimum.value, by_nlopt(function, {-2, 0.25}, {-4, -1}, {4, 1}).value * (1 + 1e-8));
}

TEST(LevenbergMarquardt, never_ends_above_its_start_nor_where_nothing_is_finite) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    // Half of the plane, in which the optimum lies, is not finite.
    const ExpandedFunction half = [&](const Point& x) {
        Expansion at = rosenbrock(x);
        if (x[0] > 0.5)
            at.value = at.gradient[0] = nan;
        return at;
    };
    for (const double from : {-1.5, -0.5, 0.49}) {
        const Minimum minimum = levenberg_marquardt(half, {from, 1}, {-2, -2}, {2, 2}, {});
        EXPECT_LE(minimum.x[0], 0.5);
        EXPECT_LE(minimum.value, rosenbrock({from, 1}).value);
    }
    const Minimum lost = levenberg_marquardt(half, {1, 1}, {-2, -2}, {2, 2}, {});
    EXPECT_TRUE(std::isinf(lost.value));
    EXPECT_EQ(lost.evaluations, 1);
}

TEST(LevenbergMarquardt, ends_at_once_at_an_optimum_without_hope_and_without_parameters) {
    EXPECT_EQ(levenberg_marquardt(rosenbrock, {1, 1}, {-2, -2}, {2, 2}, {}).evaluations, 1);
    const Minimum end = levenberg_marquardt(misfit, {0, -1}, {-5, -5}, {3, 3}, {});
    DescentOptions hopeless;
    hopeless.goal = 0.5 * end.value;
    EXPECT_EQ(levenberg_marquardt(misfit, end.x, {-5, -5}, {3, 3}, hopeless).evaluations, 1);
    const ExpandedFunction constant = [](const Point&) {
        return Expansion{2, Eigen::VectorXd(0), Eigen::MatrixXd(0, 0)};
    };
    EXPECT_EQ(levenberg_marquardt(constant, {}, {}, {}, {}).value, 2);
    DescentOptions two;
    two.max_evaluations = 2;
    EXPECT_EQ(levenberg_marquardt(rosenbrock, {-1.2, 1}, {-2, -2}, {2, 2}, two).evaluations, 2);
}

TEST(Minimise, patience_ends_a_search_in_vain) {
    int calls = 0;
    const Function flat = [&](const Point& x, Point* gradient) {
        ++calls;
        if (gradient != nullptr)
            gradient->assign(x.size(), 1);
        return 1 - 1e-9 * x[0];
    };
    MinimiseOptions options;
    options.patience = 2;
    const Minimum minimum = minimise(flat, {0.5}, {0}, {1}, options);
    EXPECT_LE(calls, 4); // the start, once more by NLopt, and two in vain
    EXPECT_LE(minimum.value, 1 - 0.5e-9);
}

// On the errors of fits.

/// A measurement that no model fits, of more samples than the search thins to.
const Samples& odd_measurement() {
    static const Samples samples = [] {
        Material truth = typical_material(structure_named("cook-torrance+ward-duer", 1, "", true));
        truth.lobes[0].theta[1] = 0.09;
        Samples odd = measured(truth, 60000, 0.1);
        for (std::size_t ch = 0; ch < 3; ++ch) // something between the lobes
            for (std::size_t k = 0; k < odd.count(); ++k)
                odd.channel(ch)[k] *=
                    static_cast<float>(1 + 0.3 * std::sin(9 * odd.directions->wi(k)[2] +
                                                          5 * odd.directions->wo(k)[2]));
        return odd;
    }();
    return samples;
}

/// An objective of a structure on these samples.
struct Errors {
    Structure structure;
    Space space;
    DeviceSamples packed;
    Objective objective;

    Errors(const Samples& samples, const Structure& of, const std::vector<ParameterRange>& ranges)
        : structure(of), space(of.lobes, of.isotropic, ranges),
          packed(pack_samples(device(), samples, 80, Metric::Ngan)),
          objective(device(), test::programs().get(of, packed.channels, packed.chunk), packed) {}
};

/// From random starts: descents end where NLopt finds nothing better nearby, and the best of them
/// is not above the best of NLopt's own.
void expect_descents_meet_nlopt(const std::string& model, int lobes, const std::string& bound) {
    std::vector<ParameterRange> ranges;
    if (!bound.empty())
        ranges.push_back(parse_bound(bound));
    Errors errors(odd_measurement(), structure_named(model, lobes, "", true), ranges);
    Polish descents(errors.objective, errors.space, Metric::Ngan, {});
    Polish nlopt(errors.objective, errors.space, Metric::Ngan, {});
    double best = std::numeric_limits<double>::infinity(), best_of_nlopt = best;
    std::size_t descending = 0, minimising = 0;
    for (std::uint64_t i = 0; i < 12; ++i) {
        const Solution start{errors.space.random(7, i), {}, 0};
        const std::size_t before = errors.objective.evaluations();
        const Solution end = descents.descended(start);
        const std::size_t between = errors.objective.evaluations();
        const Solution other = nlopt.minimised(start);
        descending += between - before;
        minimising += errors.objective.evaluations() - between;
        best = std::min(best, end.squared_error);
        best_of_nlopt = std::min(best_of_nlopt, other.squared_error);
        const Solution further = nlopt.minimised(end);
        EXPECT_LE(end.squared_error, further.squared_error * (1 + 1e-4))
            << model << " " << lobes << " " << bound << ", start " << i;
    }
    EXPECT_LE(best, best_of_nlopt * (1 + 1e-6)) << model << " " << lobes << " " << bound;
    EXPECT_LT(descending, minimising) << model << " " << lobes << " " << bound;
}

TEST(Descent, from_random_starts_meets_nlopt) {
    for (const char* model : {"kurt", "ward", "ggx", "ashikhmin-shirley", "cook-torrance"})
        expect_descents_meet_nlopt(model, 1, "");
    expect_descents_meet_nlopt("ward", 2, "");
    expect_descents_meet_nlopt("ggx", 2, "");
}

TEST(Descent, with_bounds_active_meets_nlopt) {
    expect_descents_meet_nlopt("kurt", 1, "m=0.3:1");
    expect_descents_meet_nlopt("kurt", 1, "alpha=1:1.2");
    expect_descents_meet_nlopt("cook-torrance", 2, "f0=0.5:0.6");
}

TEST(Descent, of_many_channels_meets_nlopt) {
    const Structure structure = structure_named("kurt", 1, "", true);
    Samples samples = measured(typical_material(structure, 19), 5000, 0.2);
    Errors errors(samples, structure_named("ggx", 1, "", true), {});
    Polish polish(errors.objective, errors.space, Metric::Ngan, {});
    const Solution start{errors.space.random(3, 1), {}, 0};
    // From the residuals themselves: sums about another solution are only good to 1e-6.
    const auto error_at = [&](const Solution& solution) {
        return errors.objective.metric_errors(solution.theta,
                                              solution.a)[static_cast<std::size_t>(Metric::Ngan)];
    };
    const double expected =
        error_at(Polish(errors.objective, errors.space, Metric::Ngan, {}).minimised(start));
    EXPECT_LE(error_at(polish.descended(start)), expected * (1 + 1e-6));
}

TEST(Descent, starts_with_lobes_alike_and_black_data_are_survived) {
    // Two equal lobes: the second explains nothing.
    Errors errors(odd_measurement(), structure_named("ward", 2, "", true), {});
    Polish polish(errors.objective, errors.space, Metric::Ngan, {});
    const Solution twins = polish.descended({{0.1, 0.1}, {}, 0});
    EXPECT_TRUE(std::isfinite(twins.squared_error));
    Samples black = odd_measurement();
    std::fill(black.values.begin(), black.values.end(), 0.0F);
    Errors nothing(black, structure_named("kurt", 2, "", true), {});
    Polish idle(nothing.objective, nothing.space, Metric::Ngan, {});
    EXPECT_EQ(idle.descended({nothing.space.random(1, 1), {}, 0}).squared_error, 0);
}

TEST(Fit, takes_few_evaluations_on_all_samples) {
    const double most[] = {8, 14}; // medians over all models; one lobe, two
    for (const int lobes : {1, 2}) {
        FileFitter fitter(device(), test::programs(), odd_measurement(), {});
        std::vector<std::size_t> evaluations;
        for (const std::string& model : test::fitted_model_names())
            evaluations.push_back(fitter.fit(structure_named(model, lobes, "", true)).evaluations);
        std::sort(evaluations.begin(), evaluations.end());
        EXPECT_LE(static_cast<double>(evaluations[evaluations.size() / 2]), most[lobes - 1])
            << lobes;
    }
}

// Several at once.

std::vector<FitResult> all_fits(std::size_t jobs, const FitOptions& options,
                                const std::vector<Structure>& structures) {
    std::vector<FitResult> results(structures.size());
    std::size_t begun = 0, ended = 0;
    FitPlace place;
    place.at_once = jobs;
    FitCalls calls;
    calls.next = [&](std::size_t) {
        ++begun;
        return ProgressFunction{};
    };
    calls.done = [&](FitOutcome outcome) {
        ++ended;
        if (outcome.failure)
            std::rethrow_exception(outcome.failure);
        results.at(outcome.index) = std::move(*outcome.result);
    };
    EXPECT_FALSE(
        fit_all(test::fit_devices(), odd_measurement(), options, structures, place, calls));
    EXPECT_EQ(begun, structures.size());
    EXPECT_EQ(ended, structures.size());
    return results;
}

void expect_the_same_bits(const std::vector<Structure>& structures, const FitOptions& options,
                          const std::vector<std::size_t>& jobs) {
    const std::vector<FitResult> alone = all_fits(1, options, structures);
    for (const std::size_t at_once : jobs) {
        const std::vector<FitResult> together = all_fits(at_once, options, structures);
        for (std::size_t i = 0; i < structures.size(); ++i) {
            EXPECT_EQ(alone[i].model, structures[i].name());
            EXPECT_EQ(to_json(together[i].material), to_json(alone[i].material)) << at_once;
            EXPECT_EQ(together[i].theta, alone[i].theta) << at_once;
            EXPECT_EQ(together[i].errors, alone[i].errors) << at_once;
            EXPECT_EQ(together[i].evaluations, alone[i].evaluations) << at_once;
        }
    }
}

TEST(FitAll, gives_the_same_bits_whatever_the_jobs) {
    std::vector<Structure> structures;
    for (const char* model : {"kurt", "ward", "ggx", "ward+ggx", "cook-torrance"})
        structures.push_back(structure_named(model, 1, "", true));
    for (const char* model : {"ggx", "ward", "cook-torrance"})
        structures.push_back(structure_named(model, 2, "", true));
    expect_the_same_bits(structures, {}, {2, 40});
}

TEST(FitAll, gives_the_same_bits_with_random_starts_other_metrics_and_limits) {
    const std::vector<Structure> structures{
        structure_named("ward", 1, "", true), structure_named("ggx", 1, "", true),
        structure_named("ward+ggx", 1, "", true), structure_named("ward", 2, "", true)};
    FitOptions starting, compressed, conserving;
    starting.random_starts = 2;
    expect_the_same_bits(structures, starting, {3});
    compressed.metric = Metric::Log;
    compressed.max_evaluations = 10;
    expect_the_same_bits({structures[0], structures[1]}, compressed, {2});
    conserving.conserve = true;
    expect_the_same_bits({structures[0], structures[1], structures[3]}, conserving, {2});
}

TEST(FitAll, one_that_fails_does_not_touch_the_others) {
    FitOptions options;
    options.start = typical_material(structure_named("ward", 1, "", true));
    std::size_t done = 0, failed = 0;
    const std::vector<Structure> structures{structure_named("kurt", 1, "", true),
                                            structure_named("ward", 1, "", true)};
    FitPlace place;
    FitCalls calls;
    calls.done = [&](const FitOutcome& outcome) {
        done += outcome.result ? 1 : 0;
        failed += outcome.failure ? 1 : 0;
        EXPECT_EQ(outcome.result.has_value(), outcome.index == 1);
    };
    const auto fit_them = [&] {
        return fit_all(test::fit_devices(), odd_measurement(), options, structures, place, calls);
    };
    EXPECT_FALSE(fit_them());
    EXPECT_EQ(done, 1U);
    EXPECT_EQ(failed, 1U);
    calls.done = [](const FitOutcome&) { throw InputError("enough"); }; // comes out
    for (place.at_once = 1; place.at_once <= 2; ++place.at_once)
        EXPECT_THROW(fit_them(), InputError);
}

} // namespace

} // namespace brdfit

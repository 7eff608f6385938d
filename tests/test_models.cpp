// What must hold for every model of the catalogue: the kernels equal the papers' equations, and do
// what the catalogue says of them. A new model is covered without being named here.

#include "host/embedded.hpp"
#include "host/evaluate/evaluate.hpp"
#include "tests/support/models.hpp"
#include "tests/support/pairs.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

namespace brdfit {

using namespace test;

namespace {

using Theta = std::vector<double>;
Vector rotated(const Vector& w, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * w[0] - s * w[1], s * w[0] + c * w[1], w[2]};
}

/// What evaluate_model takes as theta: a diffuse shape that goes with a lobe depends on its f0.
std::vector<Parameter> parameters_of(const Model& model, bool isotropic) {
    if (model.kind == Kind::DiffuseAndLobe)
        return {model_named(model.lobe).isotropic[0]};
    return model.parameters(isotropic);
}

/// The parameter `fraction` of the way from bound to bound, in its own spacing, as float32 has it.
double at_fraction(const Parameter& p, double fraction) {
    double value = p.lower + fraction * (p.upper - p.lower);
    if (p.scale == Scale::Log)
        value = p.lower * std::pow(p.upper / p.lower, fraction);
    if (p.scale == Scale::Log1p)
        value = (1 + p.lower) * std::pow((1 + p.upper) / (1 + p.lower), fraction) - 1;
    return static_cast<float>(value);
}

/// Every combination of the fractions over the parameters.
std::vector<Theta> grid(const std::vector<Parameter>& parameters,
                        const std::vector<double>& fractions) {
    std::vector<Theta> thetas = {{}};
    for (const Parameter& p : parameters) {
        std::vector<Theta> longer;
        for (const Theta& theta : thetas)
            for (const double fraction : fractions) {
                longer.push_back(theta);
                longer.back().push_back(at_fraction(p, fraction));
            }
        thetas = longer;
    }
    return thetas;
}

/// Bounds and middles in every combination, and a few between.
std::vector<Theta> chosen_thetas(const std::vector<Parameter>& parameters) {
    std::vector<Theta> thetas = grid(parameters, {0, 0.5, 1});
    Random random(2);
    for (int i = 0; i < 8 && !parameters.empty(); ++i) {
        Theta theta;
        for (const Parameter& p : parameters)
            theta.push_back(at_fraction(p, uniform(random)));
        thetas.push_back(theta);
    }
    return thetas;
}

/// The change of a parameter that matters as much wherever it stands in its range.
double unit(const Parameter& p, double value) {
    switch (p.scale) {
    case Scale::Log:
        return value;
    case Scale::Log1p:
        return 1 + value;
    case Scale::Linear:
    case Scale::AboutOne:
    case Scale::Angle:
        break;
    }
    return p.upper - p.lower;
}

/// A model in one form with one theta, by the reference.
struct Expected {
    const Model& model;
    bool isotropic;
    std::vector<Parameter> parameters;
    Theta theta;

    bool fresnel() const { return !parameters.empty() && parameters[0].name == "f0"; }
    double value(const Pair& pair, const Theta& at) const {
        return reference_value(model.name, isotropic, at, pair.wi, pair.wo);
    }
    /// As far as a result of the value moves when the directions are rounded to float32: a model
    /// may be the small difference of large numbers. `result` of a function of theta.
    template <typename Result>
    double rounding(const Pair& pair, Result result) const {
        const double exact = result([&](const Theta& at) { return value(pair, at); });
        double sum = 0;
        for (std::size_t k = 0; k < 6; ++k) {
            double largest = 0;
            for (const double change : {-2.0, -1.0, 1.0, 2.0}) {
                const double moved = result([&](const Theta& at) {
                    return reference_value_rounded(model.name, isotropic, at, pair.wi, pair.wo, k,
                                                   change);
                });
                largest = std::max(largest, std::abs(moved - exact));
            }
            sum += largest;
        }
        return sum;
    }
    /// theta with f0 = 1: the lobe without Fresnel.
    Theta full_theta() const {
        Theta full = theta;
        if (fresnel() && model.kind == Kind::Lobe)
            full[0] = 1;
        return full;
    }
    std::string text() const {
        return fmt::format("{} {} theta ({:.9g})", model.name, isotropic ? "isotropic" : "",
                           fmt::join(theta, ", "));
    }
};

/// Absolute error that float32's 1 - c leaves in Schlick's F.
double fresnel_tolerance(const Pair& pair) {
    const Vector& i = pair.wi;
    const Vector& o = pair.wo;
    const double c =
        std::sqrt(std::pow(i[0] + o[0], 2) + std::pow(i[1] + o[1], 2) + std::pow(i[2] + o[2], 2)) /
        2;
    return 5 * std::pow(std::abs(1 - c), 4) * 1.2e-7 + 1e-30;
}

/// Central difference of the reference by parameter p, and what the difference itself may be off
/// by: what the one-sided ones differ, so that at a kink either side is right; infinite where the
/// lobe ends within the step.
struct Slope {
    double value, uncertainty;
};

template <typename Value>
Slope slope(Value value_at, const Parameter& parameter, Theta at, std::size_t p,
            double relative_step = 1e-9) {
    const double middle = at[p], value = value_at(at);
    const double step = relative_step * unit(parameter, middle);
    at[p] = middle + step;
    const double up = at[p] - middle, above = value_at(at);
    at[p] = middle - step;
    const double down = middle - at[p], below = value_at(at);
    if (value > 0 && (above == 0 || below == 0))
        return {0, huge};
    const double forward = (above - value) / up, backward = (value - below) / down;
    return {(forward + backward) / 2, std::abs(forward - backward)};
}

Slope slope(const Expected& expected, const Pair& pair, const Theta& at, std::size_t p) {
    return slope([&](const Theta& theta) { return expected.value(pair, theta); },
                 expected.parameters[p], at, p);
}

/// As far as slope() is off: by the rounding of directions, and by the size of its step.
double slope_rounding(const Expected& expected, const Pair& pair, std::size_t p) {
    const auto by = [&](double step) {
        return [&expected, p, step](auto value_at) {
            return slope(value_at, expected.parameters[p], expected.theta, p, step).value;
        };
    };
    const auto exact = [&](const Theta& at) { return expected.value(pair, at); };
    return expected.rounding(pair, by(1e-9)) + std::abs(by(1e-9)(exact) - by(1e-12)(exact));
}

void compare_with_reference(const Expected& expected, const std::vector<Pair>& pairs,
                            const Directions& directions) {
    SCOPED_TRACE(expected.text());
    Mismatches mismatches;
    const ModelValues values =
        evaluate_model(device(), expected.model, expected.isotropic, expected.theta, directions);
    ASSERT_EQ(values.value.size(), pairs.size());
    ASSERT_EQ(values.derivatives.size(), expected.parameters.size());
    const bool diffuse = expected.model.kind != Kind::Lobe;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const Pair& pair = pairs[k];
        const double reference = expected.value(pair, expected.theta);
        const double full = expected.value(pair, expected.full_theta());
        const double value = values.value[k];
        const double fresnel = expected.fresnel() ? fresnel_tolerance(pair) : 0;
        if (full > huge) {
            mismatches.check(std::isfinite(value) && value >= 0, "value", pair, value, reference,
                             0);
            continue;
        }
        const double relative = relative_tolerance(full);
        // A diffuse shape is of the order of 1, and 1 - F cancels.
        const double floor = diffuse ? 1e-6 : tiny + fresnel * full;
        mismatches.check_near("value", pair, value, reference, relative * reference + floor, [&] {
            return expected.rounding(pair, [&](auto value_at) { return value_at(expected.theta); });
        });
        for (std::size_t p = 0; p < expected.parameters.size(); ++p) {
            const Parameter& parameter = expected.parameters[p];
            const Slope by = slope(expected, pair, expected.theta, p);
            if (std::abs(by.value) > huge)
                continue;
            const double scale = unit(parameter, expected.theta[p]);
            double tolerance = relative * std::abs(by.value) + by.uncertainty +
                               (2e-5 * reference + 1e3 * floor) / scale;
            if (parameter.name == "f0") // the slope is (1 - p5) S, which cancels at grazing
                tolerance += 1e-6 * full;
            else if (fresnel > 0)
                tolerance +=
                    fresnel * std::abs(slope(expected, pair, expected.full_theta(), p).value);
            mismatches.check_near("derivative by " + parameter.name, pair, values.derivatives[p][k],
                                  by.value, tolerance,
                                  [&] { return slope_rounding(expected, pair, p); });
        }
    }
}

/// Directional albedo of the reference at wo, by the half vector: log-spaced tangents resolve every
/// roughness.
double albedo(const Expected& expected, double theta_o) {
    constexpr int steps = 320, azimuths = 144;
    const double lower = std::log(1e-6), upper = std::log(1e3);
    const Vector wo = direction(theta_o, 0);
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double tangent = std::exp(lower + (upper - lower) * (i + 0.5) / steps);
        // sin(theta) d(theta), with d(theta) = cos^2 tan d(log tan)
        const double measure =
            std::pow(tangent, 2) / std::pow(1 + tangent * tangent, 1.5) * (upper - lower) / steps;
        for (int j = 0; j < azimuths; ++j) {
            // The lobe and wo are mirror images of themselves in y: half a turn will do.
            const Vector h = at_tangent(tangent, pi * (j + 0.5) / azimuths);
            const double c = wo[0] * h[0] + wo[1] * h[1] + wo[2] * h[2];
            if (c <= 0)
                continue;
            const Vector wi = mirrored(wo, h);
            if (wi[2] > 0)
                sum += expected.value({wi, wo}, expected.theta) * wi[2] * 4 * c * measure *
                       (2 * pi / azimuths);
        }
    }
    return sum;
}

const std::vector<double> polar_degrees = {0, 30, 60, 80, 85, 89};

double largest_albedo(const Expected& expected) {
    double largest = 0;
    for (const double degrees : polar_degrees)
        largest = std::max(largest, albedo(expected, degrees * pi / 180));
    return largest;
}

class EveryModel : public testing::TestWithParam<std::string> {
  protected:
    const Model& model = model_named(GetParam());
};
class ReciprocalModel : public EveryModel {};
class ConservingModel : public EveryModel {};

} // namespace

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryModel, testing::ValuesIn(all_model_names()), test_name);
INSTANTIATE_TEST_SUITE_P(
    Catalogue, ReciprocalModel,
    testing::ValuesIn(model_names([](const Model& m) { return m.reciprocal; })), test_name);
INSTANTIATE_TEST_SUITE_P(
    Catalogue, ConservingModel,
    testing::ValuesIn(model_names([](const Model& m) { return m.conserves_energy; })), test_name);

TEST_P(EveryModel, equals_its_equation_isotropic) {
    const std::vector<Pair> pairs = chosen_pairs();
    const Directions directions = directions_of(pairs);
    const std::vector<Parameter> parameters = parameters_of(model, true);
    for (const Theta& theta : chosen_thetas(parameters))
        compare_with_reference({model, true, parameters, theta}, pairs, directions);
}

TEST_P(EveryModel, equals_its_equation_anisotropic) {
    const std::vector<Pair> pairs = chosen_pairs();
    const Directions directions = directions_of(pairs);
    const std::vector<Parameter> parameters = parameters_of(model, false);
    for (const Theta& theta : chosen_thetas(parameters))
        compare_with_reference({model, false, parameters, theta}, pairs, directions);
}

TEST_P(ReciprocalModel, is_reciprocal) {
    std::vector<Pair> pairs = chosen_pairs(), swapped;
    for (const Pair& pair : pairs)
        swapped.push_back({pair.wo, pair.wi});
    const std::vector<Parameter> parameters = parameters_of(model, false);
    for (const Theta& theta : grid(parameters, {0, 0.6})) {
        SCOPED_TRACE(fmt::format("theta ({:.9g})", fmt::join(theta, ", ")));
        Mismatches mismatches;
        const ModelValues one = evaluate_model(device(), model, false, theta, directions_of(pairs));
        const ModelValues other =
            evaluate_model(device(), model, false, theta, directions_of(swapped));
        for (std::size_t k = 0; k < pairs.size(); ++k)
            mismatches.check_near("exchanged", pairs[k], other.value[k], one.value[k],
                                  1e-5 * one.value[k]);
    }
}

TEST_P(EveryModel, is_finite_and_not_negative) {
    Random random(3);
    std::vector<Pair> pairs = special_pairs();
    // Far beyond what any measurement has.
    for (const double z : {1e-10, 1e-20, 1e-30})
        for (const double other : {z, 1e-3, 1.0})
            for (const double phi : {0.0, 1.0, pi})
                pairs.push_back({at_height(z, 0), at_height(other, phi)});
    // With six sets of parameters: ten million.
    while (pairs.size() < 10000000 / 6 + 1)
        pairs.push_back(extreme_pair(random, pairs.size()));
    const Directions directions = directions_of(pairs);
    for (const bool isotropic : {true, false})
        for (const double fraction : {0.0, 0.4, 1.0}) {
            Theta theta;
            for (const Parameter& p : parameters_of(model, isotropic))
                theta.push_back(at_fraction(p, fraction));
            SCOPED_TRACE(fmt::format("theta ({:.9g})", fmt::join(theta, ", ")));
            Mismatches mismatches;
            const ModelValues values =
                evaluate_model(device(), model, isotropic, theta, directions);
            for (std::size_t k = 0; k < pairs.size(); ++k) {
                const double value = values.value[k];
                mismatches.check(std::isfinite(value) && value >= 0, "value", pairs[k], value, 0,
                                 0);
                // Where the kernel clamps, the equation is beyond float32, too.
                if (value > huge)
                    mismatches.check(reference_value(model.name, isotropic, theta, pairs[k].wi,
                                                     pairs[k].wo) > huge / 10,
                                     "clamped value", pairs[k], value, 0, 0);
            }
        }
}

TEST_P(EveryModel, is_zero_below_the_horizon) {
    Random random(4);
    std::vector<Pair> pairs = {{{0, 0, -1}, {0, 0, 1}},   {{0, 0, 1}, {0, 0, -1}},
                               {{0, 0, -1}, {0, 0, -1}},  {{1, 0, 0}, {0, 0, 1}},
                               {{0, 0, 1}, {0, 1, -0.0}}, {{1, 0, 0}, {-1, 0, 0}},
                               {{1, 0, 0}, {1, 0, 0}},    {{0.6, 0, 0.8}, {-0.6, 0, -0.8}}};
    for (int i = 0; i < 1000; ++i) {
        Pair pair = random_pair(random);
        (i % 2 == 0 ? pair.wi : pair.wo)[2] *= -1;
        if (i % 3 == 0)
            (i % 2 == 0 ? pair.wo : pair.wi)[2] *= -1;
        pairs.push_back(pair);
    }
    const Directions directions = directions_of(pairs);
    for (const Theta& theta : grid(parameters_of(model, false), {0.5, 1})) {
        Mismatches mismatches;
        const ModelValues values = evaluate_model(device(), model, false, theta, directions);
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            mismatches.check_near("value", pairs[k], values.value[k], 0, 0);
            for (const std::vector<float>& derivative : values.derivatives)
                mismatches.check_near("derivative", pairs[k], derivative[k], 0, 0);
        }
    }
}

TEST_P(EveryModel, isotropic_form_is_the_anisotropic_with_equal_roughness) {
    const std::vector<Pair> pairs = chosen_pairs();
    const Directions directions = directions_of(pairs);
    for (const Theta& theta : grid(parameters_of(model, true), {0.3, 0.7})) {
        Theta both = theta;
        if (model.kind == Kind::Lobe)
            both = Lobe{&model, true, theta, {}}.anisotropic_theta();
        SCOPED_TRACE(fmt::format("theta ({:.9g})", fmt::join(theta, ", ")));
        Mismatches mismatches;
        const ModelValues one = evaluate_model(device(), model, true, theta, directions);
        const ModelValues two = evaluate_model(device(), model, false, both, directions);
        for (std::size_t k = 0; k < pairs.size(); ++k)
            mismatches.check_near("anisotropic form", pairs[k], two.value[k], one.value[k],
                                  relative_tolerance(one.value[k]) * one.value[k] + tiny);
    }
}

TEST_P(EveryModel, isotropic_form_knows_no_azimuth) {
    const std::vector<Pair> pairs = chosen_pairs();
    const Directions directions = directions_of(pairs);
    for (const Theta& theta : grid(parameters_of(model, true), {0.3, 0.7})) {
        const ModelValues still = evaluate_model(device(), model, true, theta, directions);
        for (const double angle : {0.5, pi / 2, 2.5}) {
            SCOPED_TRACE(fmt::format("theta ({:.9g}) angle {}", fmt::join(theta, ", "), angle));
            std::vector<Pair> turned;
            for (const Pair& pair : pairs)
                turned.push_back({rotated(pair.wi, angle), rotated(pair.wo, angle)});
            Mismatches mismatches;
            const ModelValues values =
                evaluate_model(device(), model, true, theta, directions_of(turned));
            for (std::size_t k = 0; k < pairs.size(); ++k)
                mismatches.check_near("turned", pairs[k], values.value[k], still.value[k],
                                      relative_tolerance(still.value[k]) * still.value[k] + 1e-6);
        }
    }
}

TEST_P(ConservingModel, reflects_no_more_than_it_receives) {
    for (const bool isotropic : {true, false}) {
        std::vector<Parameter> parameters = parameters_of(model, isotropic);
        const bool fresnel = !parameters.empty() && parameters[0].name == "f0";
        if (fresnel)
            parameters.erase(parameters.begin());
        const std::vector<double> fractions =
            isotropic ? std::vector<double>{0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.85, 1}
                      : std::vector<double>{0.1, 0.5, 0.9};
        for (Theta theta : grid(parameters, fractions)) {
            if (fresnel)
                theta.insert(theta.begin(), 1);
            const Expected expected{model, isotropic, parameters_of(model, isotropic), theta};
            EXPECT_LE(largest_albedo(expected), 1 + 1e-3) << expected.text();
        }
    }
}

// Kurt, Szirmay-Kalos, Krivanek 2010: energy is conserved at alpha = 0, and only there.
TEST(Kurt, conserves_energy_at_alpha_zero) {
    const Model& kurt = model_named("kurt");
    const auto with = [&](double m, double alpha) {
        return Expected{kurt, true, kurt.isotropic, {1, m, alpha}};
    };
    for (const double m : {0.001, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0})
        EXPECT_LE(largest_albedo(with(m, 0)), 1 + 1e-3) << m;
    EXPECT_NEAR(albedo(with(0.3, 0.5), 89 * pi / 180), 2.1, 0.05);
}

TEST(KurtPlausible, conserves_energy_for_moderate_roughness) {
    const Model& model = model_named("kurt-plausible");
    const auto with = [&](double m) { return Expected{model, true, model.isotropic, {1, m}}; };
    for (const double m : {0.001, 0.03, 0.1, 0.3, 1.0, 1.8})
        EXPECT_LE(largest_albedo(with(m)), 1 + 1e-3) << m;
    // Its largest albedo is that at grazing.
    EXPECT_NEAR(albedo(with(2), 89.9 * pi / 180), 1.05, 0.01);
    EXPECT_NEAR(albedo(with(10), 89.9 * pi / 180), 4.4, 0.05);
}

// What brdfit demo fits must look like a material: no channel reflects more than it receives.
TEST(DemoMaterials, reflect_no_more_than_they_receive) {
    for (const EmbeddedFile* file = embedded_demo; file->name != nullptr; ++file) {
        const Material material = parse_material(file->text, file->name);
        for (std::size_t ch = 0; ch < material.channels.size(); ++ch)
            for (const double degrees : {0, 30, 60, 75}) {
                const double theta_o = degrees * pi / 180;
                double sum = material.kd[ch];
                for (const Lobe& lobe : material.lobes)
                    sum +=
                        lobe.ks[ch] * albedo({*lobe.model, lobe.isotropic,
                                              lobe.model->parameters(lobe.isotropic), lobe.theta},
                                             theta_o);
                EXPECT_LE(sum, 1) << file->name << " " << material.channels[ch] << " " << degrees;
                EXPECT_GT(sum, 0.02) << file->name;
            }
    }
}

} // namespace brdfit

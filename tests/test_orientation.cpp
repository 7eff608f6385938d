// Lobes whose tangent frame is turned about the normal (oriented): the model seen from another
// side, in values, derivatives, draws, albedos and fits. A new anisotropic model is covered without
// being named here.

#include "fit/structures.hpp"
#include "host/albedo/material.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/sample.hpp"
#include "tests/support/chi_square.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/models.hpp"
#include "tests/support/pairs.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

namespace brdfit::test {

namespace {

/// A lobe of roughness `along` its own x and `across` it; an exponent n stands for sqrt(2 / n).
Lobe turned_lobe(const Model& model, double along, double across, double angle) {
    Lobe lobe{oriented(model), false, {}, {0.4}};
    bool first = true;
    for (const Parameter& p : lobe.model->anisotropic) {
        const double roughness = std::exchange(first, first && !p.width()) ? along : across;
        double value = p.scale == Scale::Linear ? 0.3 : p.start;
        if (p.scale == Scale::Log)
            value = roughness;
        else if (p.scale == Scale::Log1p)
            value = 2 / (roughness * roughness);
        else if (p.scale == Scale::AboutOne)
            value = p.name == "Cx" ? -1.1 : -0.8;
        lobe.theta.push_back(static_cast<float>(std::clamp(value, p.lower, p.upper)));
    }
    lobe.theta.back() = angle;
    return lobe;
}

/// Apart by no more than half turns and `tolerance`.
void expect_same_angle(double found, double expected, double tolerance) {
    const double apart = std::remainder(found - expected, 180);
    EXPECT_LE(std::abs(apart), tolerance) << found << ", expected " << expected;
}

Material turned_material(const std::string& model, double along, double across, double angle) {
    Material material = material_of({turned_lobe(model_named(model), along, across, angle)}, 0.2);
    return material;
}

std::vector<std::string> oriented_names() {
    return model_names([](const Model& m) { return oriented(m) != nullptr; });
}

class EveryOriented : public testing::TestWithParam<std::string> {
  protected:
    const Model& model = model_named(GetParam());
    const Model& turned = *oriented(model);
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryOriented, testing::ValuesIn(oriented_names()), test_name);

TEST_P(EveryOriented, is_the_model_in_a_turned_frame) {
    const auto pairs = random_directions(4000, false, 7);
    for (const double angle : {30.0, -77.0, 180.0}) {
        const std::vector<double> theta = turned_lobe(model, 0.5, 0.15, angle).theta;
        const ModelValues found = evaluate_model(device(), turned, false, theta, *pairs);
        ASSERT_EQ(found.derivatives.size(), theta.size());
        const auto value_at = [&](std::size_t k, const std::vector<double>& at) {
            const auto [wi, wo] = pairs->pair(k);
            const std::vector<double> own(at.begin(), at.end() - 1);
            return reference_value(model.name, false, own, seen_turned(wi, at.back()),
                                   seen_turned(wo, at.back()));
        };
        std::vector<double> steepest(theta.size());
        std::vector<std::vector<double>> slopes(theta.size());
        double largest = 0;
        for (std::size_t k = 0; k < pairs->count(); ++k) {
            largest = std::max(largest, value_at(k, theta));
            for (std::size_t p = 0; p < theta.size(); ++p) {
                const double step = 1e-6 * std::max(std::abs(theta[p]), 0.1);
                std::vector<double> up = theta, down = theta;
                up[p] += step;
                down[p] -= step;
                slopes[p].push_back((value_at(k, up) - value_at(k, down)) / (2 * step));
                steepest[p] = std::max(steepest[p], std::abs(slopes[p].back()));
            }
        }
        for (std::size_t k = 0; k < pairs->count(); ++k) {
            const double value = value_at(k, theta);
            ASSERT_NEAR(found.value[k], value, 2e-4 * value + 1e-6 * largest) << angle << " " << k;
            for (std::size_t p = 0; p < theta.size(); ++p)
                ASSERT_NEAR(found.derivatives[p][k], slopes[p][k],
                            1e-3 * std::abs(slopes[p][k]) + 2e-5 * steepest[p])
                    << turned.anisotropic[p].name << " at " << angle << ", pair " << k;
        }
    }
}

TEST_P(EveryOriented, is_reciprocal_where_the_model_is) {
    if (!model.reciprocal)
        GTEST_SKIP() << model.name << " is not reciprocal";
    const auto pairs = random_directions(2000, false, 8);
    Directions swapped(pairs->count());
    for (std::size_t k = 0; k < pairs->count(); ++k)
        swapped.set(k, pairs->wo(k), pairs->wi(k));
    const std::vector<double> theta = turned_lobe(model, 0.6, 0.2, 50).theta;
    const std::vector<float> there = evaluate_model(device(), turned, false, theta, *pairs).value,
                             back = evaluate_model(device(), turned, false, theta, swapped).value;
    for (std::size_t k = 0; k < pairs->count(); ++k)
        ASSERT_NEAR(back[k], there[k], 2e-5F * there[k] + 1e-30F) << k;
}

TEST_P(EveryOriented, follows_its_density) {
    const std::vector<std::string> names = oriented_names();
    const auto place = std::find(names.begin(), names.end(), model.name) - names.begin();
    const Model& next = model_named(names[static_cast<std::size_t>(place + 1) % names.size()]);
    expect_samples_follow_density(
        material_of({turned_lobe(model, 0.1, 0.3, -60), turned_lobe(next, 0.5, 0.2, 20)}, 0.3),
        400000);
}

TEST_P(EveryOriented, has_the_albedo_of_the_viewer_in_its_frame) {
    const double angle = 30;
    const Material there = material_of({turned_lobe(model, 0.5, 0.15, angle)}, 0.1);
    Material here = there;
    here.lobes[0].model = &model;
    here.lobes[0].theta.pop_back();
    AlbedoGrid grid;
    grid.thetas = 6; // up to the horizon, where some have none
    grid.phis = 12;  // every 30 degrees
    const Albedo turned_albedo = albedo(device(), there, grid, 1e-4),
                 own_albedo = albedo(device(), here, grid, 1e-4);
    double varies = 0;
    for (std::size_t j = 0; j < grid.phis; ++j)
        for (std::size_t i = 0; i + 1 < grid.thetas; ++i) {
            const std::size_t at = (j + 1) % grid.phis * grid.thetas + i;
            const double r = own_albedo.values[0][j * grid.thetas + i];
            EXPECT_NEAR(turned_albedo.values[0][at], r, 3e-4) << i << " " << j;
            varies = std::max(varies, std::abs(r - own_albedo.values[0][i]));
            if (model.conserves_energy) {
                EXPECT_LE(turned_albedo.values[0][at], 0.1 + 0.4 + 2e-4);
            }
        }
    EXPECT_GT(varies, 2e-3); // it is not the same at every azimuth
}

TEST_P(EveryOriented, reads_and_writes_its_material) {
    const Material material = material_of({turned_lobe(model, 0.5, 0.1, -12.5)}, 0.2);
    const Material again = parse_material(to_json(material).dump(), "again");
    EXPECT_EQ(again.lobes.at(0).model, &turned);
    EXPECT_EQ(again.lobes[0].theta, material.lobes[0].theta);
    EXPECT_FALSE(again.isotropic());
    Material round = material;
    round.lobes[0] = turned_lobe(model, 0.2, 0.2, 40);
    for (const char* factor : {"Cx", "Cy"}) // of lafortune
        for (std::size_t i = 0; i < round.lobes[0].theta.size(); ++i)
            if (turned.anisotropic[i].name == factor)
                round.lobes[0].theta[i] = -1;
    EXPECT_TRUE(round.isotropic());
}

// Angles near the ends of their range and between the search's, broad lobes and sharp ones; the
// wider roughness comes first.
TEST_P(EveryOriented, is_recovered_from_noisy_data) {
    for (const auto& [along, across, angle] :
         {std::tuple{0.5, 0.1, 67.0}, {0.12, 0.06, -89.5}, {0.3, 0.2, 5.6}}) {
        SCOPED_TRACE(fmt::format("{} {} {}", along, across, angle));
        const Material truth = turned_material(model.name, along, across, angle);
        const Samples samples = measured(truth, 20000, 0.02);
        const FitResult result =
            fit(samples, brdfit::turned(structure_named(model.name, 1, "", false)));
        const Lobe& found = result.material.lobes.at(0);
        ASSERT_EQ(found.model, &turned);
        expect_same_angle(found.theta.back(), angle, 0.5);
        EXPECT_GT(found.theta.back(), -90.0);
        EXPECT_LE(found.theta.back(), 90.0);
        for (std::size_t p = 0; p < found.theta.size(); ++p)
            if (turned.anisotropic[p].width()) {
                EXPECT_NEAR(found.theta[p], truth.lobes[0].theta[p], 0.02 * found.theta[p])
                    << turned.anisotropic[p].name;
            }
        const FittedParameter& told = result.parameters.at(found.theta.size() - 1);
        EXPECT_EQ(told.name, "lobes[0].orientation");
        EXPECT_GT(told.standard_error, 0);
        EXPECT_LT(std::abs(std::remainder(told.value - angle, 180)), 6 * told.standard_error);
    }
}

TEST(Orientation, no_random_start_finds_a_better_fit) {
    FitOptions options;
    options.random_starts = 20;
    for (const char* model : {"kurt", "ward-duer", "ggx", "ashikhmin-shirley"}) {
        SCOPED_TRACE(model);
        Material truth = turned_material(model, 0.4, 0.08, 33);
        truth.lobes.push_back(turned_lobe(model_named("ward"), 0.2, 0.7, 80)); // no model has both
        const Samples samples = measured(truth, 3000, 0.1);
        const FitResult result =
            fit(samples, turned(structure_named(model, 1, "", false)), options);
        EXPECT_EQ(result.random_starts_better, 0);
    }
}

TEST(Orientation, two_lobes_are_told_apart) {
    for (const char* model : {"ggx", "kurt"}) {
        SCOPED_TRACE(model);
        Material truth = turned_material(model, 0.6, 0.2, 20);
        truth.lobes.push_back(turned_lobe(model_named(model), 0.15, 0.04, -50));
        truth.lobes[1].ks[0] *= 0.1;
        const Samples samples = measured(truth, 30000, 0.02);
        FitOptions options;
        options.random_starts = 4;
        const FitResult result =
            fit(samples, turned(structure_named(model, 2, "", false)), options);
        EXPECT_EQ(result.random_starts_better, 0);
        expect_same_angle(result.material.lobes.at(0).theta.back(), 20, 1);
        expect_same_angle(result.material.lobes.at(1).theta.back(), -50, 1);
    }
}

// As sharp as a grating's orders: the search's angles miss them.
TEST(Orientation, sharp_lobes_that_mirror_each_other_are_found) {
    Material truth = material_of({turned_lobe(model_named("lafortune"), 0.1, 0.1, 21)}, 0.05);
    truth.lobes[0].theta = {-1, 1, 3000, 21};
    truth.lobes.push_back(truth.lobes[0]);
    truth.lobes[1].theta.back() = -21;
    const FitResult result =
        fit(measured(truth, 30000, 0.02), turned(structure_named("lafortune", 2, "", false)));
    EXPECT_LT(error_of(result, Metric::Ngan), 2e-2);
    for (const std::size_t l : {0U, 1U})
        EXPECT_NEAR(std::abs(std::remainder(result.material.lobes.at(l).theta.back() - 90, 180)),
                    69, 0.5);
    EXPECT_LT(result.material.lobes[0].theta.back() * result.material.lobes[1].theta.back(), 0);
}

TEST(Orientation, helps_only_data_that_is_turned) {
    const Samples straight = measured(turned_material("ggx", 0.4, 0.1, 0), 10000, 0),
                  turned_data = measured(turned_material("ggx", 0.4, 0.1, 45), 10000, 0);
    const Structure without = structure_named("ggx", 1, "", false), with = turned(without);
    const auto error = [](const Samples& samples, const Structure& structure) {
        return error_of(fit(samples, structure), Metric::Ngan);
    };
    EXPECT_LT(error(straight, without), 1e-4);
    EXPECT_LT(error(straight, with), 1e-4);
    EXPECT_GT(error(turned_data, without), 1e-2);
    EXPECT_LT(error(turned_data, with), 1e-4);
}

TEST(Orientation, may_be_fixed_and_bound) {
    const Samples samples = measured(turned_material("kurt", 0.4, 0.1, 30), 5000, 0.02);
    const Structure structure = turned(structure_named("kurt", 1, "", false));
    FitOptions options;
    options.ranges = {parse_fix("orientation=20")};
    EXPECT_EQ(fit(samples, structure, options).material.lobes[0].theta.back(), 20);
    options.ranges = {parse_bound("orientation=100:140")}; // my and mx in their places
    const FitResult result = fit(samples, structure, options);
    expect_same_angle(result.material.lobes[0].theta.back(), 120, 0.5);
    EXPECT_LT(result.material.lobes[0].theta[1], result.material.lobes[0].theta[2]);
}

TEST(Orientation, other_metrics_and_conserving_fits_find_it) {
    Material truth = turned_material("ward-duer", 0.4, 0.15, -40);
    truth.lobes[0].ks[0] = 0.9;
    const Samples samples = measured(truth, 4000, 0.02);
    const Structure structure = turned(structure_named("ward-duer", 1, "", false));
    FitOptions options;
    for (const Metric metric : {Metric::L2, Metric::Log, Metric::Cbrt}) {
        options.metric = metric;
        const FitResult result = fit(samples, structure, options);
        expect_same_angle(result.material.lobes[0].theta.back(), -40, 1);
        EXPECT_GT(result.parameters.at(2).standard_error, 0);
        EXPECT_LT(result.parameters.at(2).standard_error, 1);
    }
    options = {};
    options.conserve = true;
    const FitResult result = fit(samples, structure, options);
    EXPECT_GT(fit(samples, structure).largest_albedo.value, 1.01);
    EXPECT_LE(result.largest_albedo.value, 1 + conserved_tolerance);
    expect_same_angle(result.material.lobes[0].theta.back(), -40, 3);
}

TEST(Orientation, starts_from_materials_with_and_without) {
    const Samples samples = measured(turned_material("ggx", 0.4, 0.1, 30), 3000, 0.02);
    const Structure straight = structure_named("ggx", 1, "", false);
    FitOptions options;
    options.start = turned_material("ggx", 0.3, 0.2, 10);
    expect_same_angle(fit(samples, turned(straight), options).material.lobes[0].theta.back(), 30,
                      1);
    EXPECT_THROW(fit(samples, straight, options), UsageError);
    options.start->lobes[0].model = &model_named("ggx");
    options.start->lobes[0].theta.pop_back();
    expect_same_angle(fit(samples, turned(straight), options).material.lobes[0].theta.back(), 30,
                      1);
}

TEST(Orientation, broken_ones_are_refused_by_name) {
    const auto message = [](const std::string& lobe) {
        try {
            parse_material(R"({"brdfit": 1, "channels": ["a"], "diffuse": {"model": "lambert", )"
                           R"("kd": [0]}, "lobes": [)" +
                               lobe + "]}",
                           "m.json");
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    EXPECT_EQ(message(R"({"model": "ward", "ks": [1], "mx": 0.1, "my": 0.2, "orientation": 90})"),
              "accepted");
    for (const char* value : {"190", "-180.5", "\"x\"", "null", "[1]"})
        EXPECT_NE(
            message(
                fmt::format(
                    R"({{"model": "ward", "ks": [1], "mx": 0.1, "my": 0.2, "orientation": {}}})",
                    value))
                .find("lobes[0].orientation"),
            std::string::npos)
            << value;
    EXPECT_NE(message(R"({"model": "ward", "ks": [1], "m": 0.1, "orientation": 9})")
                  .find("stands beside m; expected it beside mx and my"),
              std::string::npos);
    EXPECT_NE(message(R"({"model": "blinn-phong", "ks": [1], "n": 10, "orientation": 9})")
                  .find("a blinn-phong lobe has none"),
              std::string::npos);
}

} // namespace brdfit::test

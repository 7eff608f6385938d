// Directional and hemispherical albedos: the kernels against float64 quadrature of the reference
// equations, the command, and what is measured.
#include "host/albedo/integrator.hpp"
#include "host/albedo/material.hpp"
#include "host/albedo/measured.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/image/image.hpp"
#include "host/measured/merl.hpp"
#include "host/microfacet/generator.hpp"
#include "tests/support/albedo_reference.hpp"
#include "tests/support/models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace brdfit {
namespace {

using test::device;
using test::material_of;
using test::run_program;
using test::TemporaryFolder;

/// A lobe of a model of that roughness (exponent 2 / roughness^2 - 2), f0 = 1.
Lobe lobe_of(const Model& model, double roughness) {
    Lobe lobe{&model, true, {}, {1}};
    for (const Parameter& p : model.isotropic)
        lobe.theta.push_back(p.name == "f0"          ? 1
                             : p.scale == Scale::Log ? roughness
                             : p.scale == Scale::Log1p
                                 ? std::max(p.lower, 2 / (roughness * roughness) - 2)
                                 : p.start);
    return lobe;
}

Material kurt(double m, double alpha) {
    return material_of({{&model_named("kurt"), true, {1, m, alpha}, {1}}});
}

class EveryAlbedo : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryAlbedo, testing::ValuesIn(test::lobe_model_names()),
                         test::test_name);

// Every roughness from 0.01 to 1 and every angle to 89 degrees, to 1e-4 and within the stated
// error.
TEST_P(EveryAlbedo, agrees_with_quadrature) {
    const Model& model = model_named(GetParam());
    AlbedoIntegrator integrator(device(), {&model_named("lambert"), {&model}, false}, 1);
    // The steep edge of a flat cosine lobe is beyond the reference's panels.
    const bool lafortune = model.name == "lafortune";
    std::vector<AlbedoTask> tasks;
    std::vector<std::pair<Lobe, double>> cases;
    for (const double roughness : {0.01, 0.1, lafortune ? 0.5 : 1.0})
        for (const double theta : {0.0, 60.0, 89.0}) {
            cases.push_back({lobe_of(model, roughness), roughness});
            tasks.push_back(
                {direction(theta * degree, 0.3), cases.back().first.anisotropic_theta(), 1e-4, 0});
        }
    const std::vector<AlbedoValue> values = integrator.integrate(tasks);
    for (std::size_t k = 0; k < tasks.size(); ++k) {
        const auto& [lobe, scale] = cases[k];
        const double expected =
            test::reference_albedo(model.name, true, lobe.theta, tasks[k].wo, scale);
        EXPECT_TRUE(values[k].reached);
        EXPECT_NEAR(values[k].all, expected, 1e-4)
            << "roughness " << scale << " wo.z " << tasks[k].wo[2];
        EXPECT_NEAR(values[k].all, expected, values[k].error + 1e-6);
        EXPECT_LE(values[k].error, std::max(1.0001e-4, 1e-5 * expected));
    }
}

TEST(Albedo, of_anisotropic_lobes_depends_on_the_azimuth) {
    const Lobe lobe{&model_named("ggx"), false, {1, 0.05, 0.6}, {1}};
    const Albedo found = albedo(device(), material_of({lobe}), {4, 4}, 1e-4);
    for (std::size_t k = 0; k < found.count(); ++k) {
        if (k % 4 == 3)
            continue; // the limit at 90 degrees
        const Vector wo = direction(found.theta[k], found.phi[k]);
        EXPECT_NEAR(found.values[0][k], test::reference_albedo("ggx", false, lobe.theta, wo, 0.05),
                    1e-4);
    }
    EXPECT_GT(std::abs(found.values[0][2] - found.values[0][6]), 0.01);
}

// The lobe and the diffuse term apart, against the integrator at a coarse tolerance.
TEST(Albedo, of_generated_lobes_is_what_the_integrator_finds) {
    struct Case {
        const char* spec;
        bool correlated, metal;
    };
    for (const Case& one :
         {Case{R"({"distribution": "gaussian", "sigma_x": 0.2, "sigma_y": 0.4})", true, false},
          Case{R"({"distribution": "velvet"})", false, true}}) {
        Material material = material_of({{&model_named("microfacet"), true, {0.3}, {0}}}, 0);
        material.diffuse = &model_named("microfacet-diffuse");
        material.metal = one.metal;
        Lobe& lobe = material.lobes[0];
        lobe.correlated = one.correlated;
        lobe.table = std::make_shared<MicrofacetTable>(
            test::generator().generate(parse_distribution(one.spec, "spec"), {200, false}, "spec"));
        const AlbedoGrid grid{4, material.isotropic() ? std::size_t{1} : std::size_t{3}};
        for (const std::size_t component : {0U, 1U}) {
            material.kd = {component == 0 ? 1.0 : 0.0};
            lobe.ks = {component == 1 ? 1.0 : 0.0};
            const Albedo known = albedo(device(), material, grid, 1e-4);
            AlbedoIntegrator integrator(device(), {material.diffuse, {lobe.model}, false},
                                        component, device_parameters(material, false));
            std::vector<AlbedoTask> tasks;
            for (std::size_t k = 0; k < known.count(); ++k)
                if (k % grid.thetas != grid.thetas - 1) // the limit at 90 degrees
                    tasks.push_back({direction(known.theta[k], known.phi[k]), lobe.theta, 2e-3, 0});
            const std::vector<AlbedoValue> found = integrator.integrate(tasks);
            for (std::size_t t = 0; t < tasks.size(); ++t) {
                const std::size_t k = t / (grid.thetas - 1) * grid.thetas + t % (grid.thetas - 1);
                EXPECT_NEAR(known.values[0][k], found[t].all, known.errors[0][k] + found[t].error)
                    << one.spec << " " << component << " " << known.theta[k];
                EXPECT_LT(known.errors[0][k], 1e-3) << one.spec << " " << known.theta[k];
            }
            EXPECT_GT(known.average[0], 0.01) << one.spec;
        }
    }
}

TEST(Albedo, adds_up_components_by_channel) {
    Material material = kurt(0.2, 0.1);
    material.channels = {"R", "G"};
    material.diffuse = &model_named("kurt-coupled");
    material.kd = {0.5, 0};
    material.lobes[0].ks = {0.3, 2};
    material.lobes[0].theta[0] = 0.1;
    const Albedo found = albedo(device(), material, {7, 1}, 1e-4);
    for (std::size_t k = 0; k + 1 < found.count(); ++k) {
        const Vector wo = direction(found.theta[k], 0);
        const double lobe = test::reference_albedo("kurt", true, material.lobes[0].theta, wo, 0.2);
        const double diffuse = test::reference_albedo("kurt-coupled", true, {0.1}, wo, 1);
        EXPECT_NEAR(found.values[0][k], 0.5 * diffuse + 0.3 * lobe, 1e-4);
        EXPECT_NEAR(found.values[1][k], 2 * lobe, 1e-4);
    }
}

// Kurt et al. 2010, Fig. 3: alpha = 0.5, m = 0.3, f0 = 1 reflects 2.1 times what it receives at 89
// degrees; at alpha = 0 it never reflects more.
TEST(Albedo, of_kurt_grows_above_one_with_alpha_only) {
    const AlbedoGrid grid{91, 1};
    const Albedo above = albedo(device(), kurt(0.3, 0.5), grid, 1e-4);
    EXPECT_NEAR(above.values[0][89], 2.1, 0.05);
    EXPECT_NEAR(above.values[0][89],
                test::reference_albedo("kurt", true, {1, 0.3, 0.5}, direction(89 * degree, 0), 0.3),
                1e-4);
    EXPECT_TRUE(std::isinf(above.values[0][90]));
    for (const double m : {0.1, 0.3, 0.6}) {
        const Albedo plain = albedo(device(), kurt(m, 0), grid, 1e-4);
        EXPECT_LE(*std::max_element(plain.values[0].begin(), plain.values[0].end()), 1);
    }
}

TEST(Albedo, states_infinity_where_it_diverges) {
    // At 90 degrees, where sqrt(oz) divides.
    const Albedo ward =
        albedo(device(), material_of({lobe_of(model_named("ward"), 0.3)}), {3, 1}, 1e-4);
    EXPECT_TRUE(std::isfinite(ward.values[0][1]));
    EXPECT_TRUE(std::isinf(ward.values[0][2]));
    EXPECT_TRUE(std::isfinite(ward.average[0]));
    // The integral of 1 / iz.
    const Albedo two = albedo(device(), kurt(1, 2), {3, 1}, 1e-4);
    EXPECT_TRUE(std::isinf(two.values[0][0]));
    EXPECT_TRUE(std::isinf(two.average[0]));
    // Bounded at 90 degrees.
    const Albedo gmd =
        albedo(device(), material_of({lobe_of(model_named("ward-gmd"), 0.3)}), {3, 1}, 1e-4);
    EXPECT_TRUE(std::isfinite(gmd.values[0][2]));
}

// Growing towards the horizon like iz^-0.5.
TEST(Albedo, integrates_what_grows_towards_the_horizon) {
    const Albedo found = albedo(device(), kurt(0.6, 1.5), {10, 1}, 1e-4);
    for (const std::size_t k : {0U, 3U, 6U}) {
        // The reference stops 1e-9 short of the horizon: sqrt(1e-9) of what is there.
        const double expected =
            test::reference_albedo("kurt", true, {1, 0.6, 1.5}, direction(found.theta[k], 0), 0.6);
        EXPECT_NEAR(found.values[0][k], expected, found.errors[0][k] + 2e-4 * expected);
    }
}

TEST(Albedo, averages_over_the_hemisphere) {
    Material lambert = kurt(0.3, 0);
    lambert.kd = {0.25};
    lambert.lobes.clear();
    EXPECT_NEAR(albedo(device(), lambert, {2, 1}, 1e-4).average[0], 0.25, 1e-4);
    const Albedo found =
        albedo(device(), material_of({lobe_of(model_named("ggx"), 0.3)}), {2, 1}, 1e-4);
    const double expected =
        test::average_over_cosine([](double mu) { return test::ggx_albedo(mu, 0.3).all; });
    EXPECT_NEAR(found.average[0], expected, 1e-4);
    EXPECT_LT(found.average_error[0], 3e-4);
}

TEST(Albedo, refuses_tolerances_out_of_reach) {
    for (const double tolerance : {0.0, -1e-4, 1e-9, 1.0, std::nan("")})
        EXPECT_THROW(albedo(device(), kurt(0.3, 0), {2, 1}, tolerance), UsageError) << tolerance;
}

// A material on MERL's grid has the material's albedo, but for the size of bins.
TEST(MeasuredAlbedo, of_merl_is_that_of_the_material) {
    Material material = kurt(0.3, 0.1);
    material.channels = {"R", "G", "B"};
    material.kd = {0.3, 0.2, 0.1};
    material.lobes[0].theta[0] = 0.1;
    material.lobes[0].ks = {1, 1, 1};
    Samples samples = synthesise_merl(device(), material, 0, 1, "material");
    const Albedo truth = albedo(device(), material, {10, 1}, 1e-4);
    const Albedo found = measured_albedo(samples, {10, 1}, 1e-3);
    EXPECT_TRUE(on_grid(samples));
    for (std::size_t k = 0; k < 9; ++k)
        for (std::size_t ch = 0; ch < 3; ++ch) {
            EXPECT_NEAR(found.values[ch][k], truth.values[ch][k], 0.01 * truth.values[ch][k]);
            EXPECT_NEAR(found.measured[k], 1, 0.005);
        }
    EXPECT_NEAR(found.average[1], truth.average[1], 0.005);
    // Half of it unmeasured.
    for (std::size_t bin = 0; bin < merl::bins; ++bin)
        if (samples.directions->plane(Directions::HX)[bin] > 0.2F)
            samples.valid[bin] = 0;
    const Albedo part = measured_albedo(samples, {10, 1}, 1e-3);
    EXPECT_LT(part.measured[0], 0.5);
    EXPECT_LT(part.values[0][0], found.values[0][0]);
    EXPECT_LT(part.average_measured, 0.6);
}

/// Samples of every bin of MERL's grid, all of them measured, of a function of the bin of theta_d.
template <typename OfBin>
Samples merl_of_theta_d(OfBin f) {
    Samples samples;
    samples.source = "bins";
    samples.channels = {"Y"};
    samples.directions = merl::bin_directions();
    samples.valid.assign(merl::bins, 1);
    for (std::size_t bin = 0; bin < merl::bins; ++bin)
        samples.values.push_back(static_cast<float>(f(bin / 180 % 90)));
    return samples;
}

// At the normal theta_d = theta_i / 2, and rings between its bins' edges have the projected solid
// angle pi (sin^2 of the upper - sin^2 of the lower theta_i).
TEST(MeasuredAlbedo, of_merl_is_known_to_its_stated_error) {
    const auto value = [](std::size_t j) {
        return j % 2 == 0 ? 0.4 : 0.01 * static_cast<double>(j);
    };
    const Samples striped = merl_of_theta_d(value);
    double expected = 0;
    for (std::size_t j = 0; j < 45; ++j) {
        const double lower = std::sin(2 * degree * static_cast<double>(j)),
                     upper = std::sin(2 * degree * static_cast<double>(j + 1));
        expected += value(j) * pi * (upper * upper - lower * lower);
    }
    for (const double tolerance : {2e-2, 5e-3}) {
        const Albedo found = measured_albedo(striped, {2, 1}, tolerance);
        EXPECT_NEAR(found.values[0][0], expected, found.errors[0][0] + 1e-6);
        EXPECT_GT(found.errors[0][0], 0);
        EXPECT_LE(found.errors[0][0], tolerance);
    }
    // A Lambertian one has its albedo at every viewer.
    const Samples lambert = merl_of_theta_d([](std::size_t) { return 0.7 / pi; });
    const Albedo found = measured_albedo(lambert, {7, 1}, 5e-3);
    for (std::size_t k = 0; k + 1 < found.count(); ++k)
        EXPECT_NEAR(found.values[0][k], 0.7, found.errors[0][k] + 1e-6) << k;
    EXPECT_NEAR(found.average[0], 0.7, found.average_error[0] + 1e-6);
}

TEST(MeasuredAlbedo, of_scattered_samples_integrates_what_was_measured) {
    // A grid of viewers out to 80 degrees of f = 0.3 / pi (1 + cos theta_o), one light direction.
    Samples samples;
    samples.source = "grid.csv";
    samples.channels = {"Y"};
    std::vector<std::pair<double, double>> viewers;
    for (int i = 0; i <= 20; ++i)
        for (int j = 0; j <= 18; ++j)
            viewers.push_back({4.0 * i * degree, 10.0 * j * degree});
    Directions directions(viewers.size());
    for (std::size_t k = 0; k < viewers.size(); ++k) {
        directions.set(k, direction(0.5, 0), direction(viewers[k].first, viewers[k].second));
        samples.values.push_back(static_cast<float>(0.3 / pi * (1 + std::cos(viewers[k].first))));
    }
    samples.directions = std::make_shared<const Directions>(directions);
    samples.valid.assign(viewers.size(), 1);
    const Albedo found = measured_albedo(samples, {}, 1e-4);
    ASSERT_EQ(found.count(), 1U);
    EXPECT_NEAR(found.theta[0], 0.5, 1e-6);
    // Integrals of cos (1 + cos): 0.3 (1 + 2 (1 - mu^3) / (3 (1 - mu^2))...) over what is within
    // reach.
    EXPECT_GT(found.measured[0], 0.96);
    EXPECT_LE(found.measured[0], 1);
    const double mu2 = 1 - found.measured[0], mu = std::sqrt(mu2);
    // The stated error is the difference of two rules, no bound: 1.4e-4 where 1.8e-4 are missing.
    EXPECT_NEAR(found.values[0][0], 0.3 * (1 - mu2 + 2.0 / 3 * (1 - mu2 * mu)),
                2 * found.errors[0][0]);
    EXPECT_LT(found.errors[0][0], 0.01);
    // Unmeasured quarters are not made up.
    for (std::size_t k = 0; k < viewers.size(); ++k)
        samples.valid[k] = viewers[k].second < 90 * degree;
    EXPECT_NEAR(measured_albedo(samples, {}, 1e-4).measured[0], 0.5, 0.12);
    samples.valid.assign(viewers.size(), 0);
    EXPECT_THROW(measured_albedo(samples, {}, 1e-4), InputError);
}

const char* const paint = R"({"brdfit": 1, "channels": ["R", "G"],
  "diffuse": {"model": "lambert", "kd": [0.1, 0.2]},
  "lobes": [{"model": "kurt", "ks": [0.5, 1], "f0": 1, "m": 0.3, "alpha": 0.5}]})";

TEST(AlbedoCommand, writes_csv_exr_and_plots) {
    const TemporaryFolder folder;
    test::write_file(folder / "paint.json", paint);
    const auto csv =
        run_program({"albedo", folder / "paint.json", "--theta", "10", "-o", folder / "a.csv"});
    ASSERT_EQ(csv.status, 0) << csv.err;
    EXPECT_NE(csv.out.find("hemispherical albedo"), std::string::npos);
    EXPECT_NE(csv.out.find("R > 1"), std::string::npos);
    const std::string text = test::read_file(folder / "a.csv");
    EXPECT_EQ(text.rfind("# directional albedo of paint.json", 0), 0U);
    EXPECT_NE(text.find("\ntheta,phi,R,G,R_error,G_error\n"), std::string::npos);
    EXPECT_NE(text.find("\n1.5707964,0,inf,inf,0,0\n"), std::string::npos);

    const auto exr = run_program(
        {"albedo", folder / "paint.json", "--theta", "10", "--phi", "3", "-o", folder / "a.exr"});
    ASSERT_EQ(exr.status, 0) << exr.err;
    const Image image = read_exr(folder / "a.exr");
    EXPECT_EQ(image.width, 10U);
    EXPECT_EQ(image.height, 3U);
    ASSERT_NE(image.plane("G_error"), nullptr);
    ASSERT_NE(image.plane("theta"), nullptr);
    EXPECT_NE(image.metadata.at("axes").find("theta from 0 to pi/2"), std::string::npos);
    EXPECT_NE(image.metadata.at("software").find("brdfit"), std::string::npos);

    const auto svg = run_program({"albedo", folder / "paint.json", folder / "paint.json", "--theta",
                                  "10", "--json", "-o", folder / "a.svg"});
    ASSERT_EQ(svg.status, 0) << svg.err;
    const std::string several = test::read_file(folder / "a.svg");
    EXPECT_EQ(several.rfind("<svg", 0), 0U);
    EXPECT_NE(several.find("mean over channels)</text>"), std::string::npos);
    EXPECT_NE(several.find(">directional albedo (reflected / received)<"), std::string::npos);
    EXPECT_NE(several.find(">paint (2)"), std::string::npos);
    // Of one input the channels.
    ASSERT_EQ(
        run_program({"albedo", folder / "paint.json", "--theta", "10", "-o", folder / "one.svg"})
            .status,
        0);
    const std::string one = test::read_file(folder / "one.svg");
    EXPECT_NE(one.find(">paint, channel R"), std::string::npos);
    EXPECT_NE(one.find(">paint, channel G"), std::string::npos);
    EXPECT_EQ(one.find("mean over channels"), std::string::npos);
    const auto json = nlohmann::json::parse(svg.out);
    ASSERT_EQ(json.size(), 2U);
    EXPECT_EQ(json[0]["channels"][1]["above_one"], true);
    EXPECT_GT(json[0]["channels"][1]["hemispherical"].get<double>(), 0.9);
}

TEST(Albedo, tells_its_progress) {
    test::told_shares([](const ProgressFunction& progress) {
        albedo(device(), kurt(0.3, 0.5), {20, 2}, 1e-4, progress);
    });
    test::told_shares([](const ProgressFunction& progress) {
        measured_albedo(synthesise_merl(device(), kurt(0.3, 0), 0, 1, ""), {3, 1}, 1e-1, progress);
    });
}

TEST(AlbedoCommand, prints_the_file_without_one) {
    const TemporaryFolder folder;
    const std::string material = folder / "paint.json", out = folder / "a.csv";
    test::write_file(material, paint);
    ASSERT_EQ(run_program({"albedo", material, "--theta", "4", "-o", out}).status, 0);
    const auto printed = run_program({"albedo", material, "--theta", "4"});
    EXPECT_EQ(printed.status, 0) << printed.err;
    EXPECT_EQ(printed.out, test::read_file(out));
    const auto json = run_program({"albedo", material, material, "--theta", "4", "--json"});
    EXPECT_EQ(json.status, 0) << json.err;
    EXPECT_EQ(nlohmann::json::parse(json.out).size(), 2U);
    EXPECT_EQ(run_program({"albedo", material, material}).status, 2);
}

// The second file does not take the option: what there is of the first shall not be done.
TEST(AlbedoCommand, refuses_options_before_any_work) {
    const TemporaryFolder folder;
    const std::string material = folder / "paint.json";
    test::write_file(material, paint);
    test::write_file(folder / "rows.csv", "theta_i,phi_i,theta_o,phi_o,Y\n0,0,0,0,1\n");
    const auto run = run_program({"albedo", material, folder / "rows.csv", "--tolerance", "1e-8",
                                  "--theta", "100", "-o", folder / "a.svg"});
    EXPECT_EQ(run.status, 2) << run.err;
    for (const char* option : {"--theta", "--tolerance"})
        EXPECT_EQ(
            run_program({"albedo", material, folder / "rows.csv", option,
                         option == std::string("--theta") ? "5" : "1e-3", "-o", folder / "a.svg"})
                .status,
            2);
    EXPECT_EQ(run_program({"albedo", material, folder / "none", "-o", folder / "a.svg"}).status, 1);
}

TEST(AlbedoCommand, does_not_depend_on_threads) {
    const TemporaryFolder folder;
    test::write_file(folder / "paint.json", paint);
    for (const char* threads : {"1", "4"}) {
        const auto run = run_program({"albedo", folder / "paint.json", "--theta", "5", "-o",
                                      folder / (std::string(threads) + ".csv")},
                                     {std::string("POCL_MAX_PTHREAD_COUNT=") + threads});
        ASSERT_EQ(run.status, 0) << run.err;
    }
    EXPECT_EQ(test::read_file(folder / "1.csv"), test::read_file(folder / "4.csv"));
}

TEST(AlbedoCommand, refuses_bad_command_lines) {
    const TemporaryFolder folder;
    const std::string material = folder / "paint.json", out = folder / "a.csv";
    test::write_file(material, paint);
    test::write_file(folder / "rows.csv", "theta_i,phi_i,theta_o,phi_o,Y\n0,0,0,0,1\n");
    const std::vector<std::pair<int, std::vector<std::string>>> cases = {
        {2, {"--tolerance", "0"}},    {2, {"--tolerance", "-1"}},
        {2, {"--tolerance", "1e-9"}}, {2, {"--tolerance", "nan"}},
        {2, {"--theta", "1"}},        {2, {"--theta", "0"}},
        {2, {"--phi", "0"}},          {2, {"--theta", "2000", "--phi", "2000"}},
        {2, {"--top", "2"}},          {2, {material}},
    };
    for (const auto& [status, extra] : cases) {
        std::vector<std::string> arguments{"albedo", material, "-o", out};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        const auto run = run_program(arguments);
        EXPECT_EQ(run.status, status) << extra[0] << run.err;
        EXPECT_FALSE(run.err.empty());
    }
    EXPECT_EQ(run_program({"albedo", material, "-o", folder / "a.txt"}).status, 2);
    EXPECT_EQ(run_program({"albedo", folder / "none.json", "-o", out}).status, 1);
    EXPECT_EQ(run_program({"albedo", folder / "rows.csv", "-o", out}).status, 1);
    EXPECT_EQ(run_program({"albedo", folder / "rows.csv", "--theta", "5", "-o", out}).status, 2);
    EXPECT_FALSE(std::filesystem::exists(out));
}

} // namespace
} // namespace brdfit

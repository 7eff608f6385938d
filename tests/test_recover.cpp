// Distributions recovered from measurements that a known one makes.

#include "fit/metric.hpp"
#include "fit/programs.hpp"
#include "fit/recover.hpp"
#include "fit/samples.hpp"
#include "fit/structures.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace brdfit::test {

namespace {

Material material_of(const MicrofacetTable& table, double f0, std::vector<double> kd,
                     std::vector<double> ks) {
    Material material;
    material.channels = {"R", "G"};
    material.diffuse = &model_named("lambert");
    material.kd = std::move(kd);
    Lobe lobe;
    lobe.model = &model_named("microfacet");
    lobe.theta = {f0};
    lobe.ks = std::move(ks);
    lobe.table = std::make_shared<MicrofacetTable>(table);
    material.lobes = {lobe};
    return material;
}

Samples measured(const std::string& spec, std::size_t count) {
    const Distribution distribution = generator().weighted(parse_distribution(spec, "spec"));
    const Material truth = material_of(generator().generate(distribution, {400, false}, "spec"),
                                       0.4, {0.1, 0.3}, {0.8, 0.5});
    const bool isotropic = truth.isotropic();
    return synthesise(device(), truth, random_directions(count, isotropic, 4), 0, 1);
}

double error_of(const Samples& samples, const Recovered& recovered) {
    const DeviceSamples packed = pack_samples(device(), samples, 80, Metric::Ngan);
    const Material material =
        material_of(recovered.table, recovered.f0, recovered.kd, recovered.ks);
    return value_errors(samples, packed.used, evaluate(device(), material, *samples.directions))[0];
}

double size_of(const Samples& samples) {
    const DeviceSamples packed = pack_samples(device(), samples, 80, Metric::Ngan);
    return value_errors(samples, packed.used, std::vector<float>(samples.values.size()))[0];
}

} // namespace

TEST(Recover, finds_an_isotropic_distribution) {
    const Samples samples = measured(R"({"distribution": "gaussian", "sigma": 0.3})", 12000);
    const Recovered found = recover(device(), generator(), samples, {});
    EXPECT_TRUE(found.table.isotropic());
    EXPECT_LT(error_of(samples, found), 5e-3 * size_of(samples));
    for (std::size_t ch = 0; ch < 2; ++ch)
        EXPECT_NEAR(found.kd[ch], ch == 0 ? 0.1 : 0.3, 0.02);
    // p against the truth, both 1 at the normal.
    const DirectionTable& p = *found.table.distribution.parts[0].table;
    for (std::size_t i = 0; i < p.thetas.size(); ++i)
        if (p.thetas[i] < 0.5) {
            EXPECT_NEAR(p.values[i] / p.values[2],
                        std::exp(-std::pow(std::tan(p.thetas[i]) / 0.3, 2)), 0.05)
                << p.thetas[i];
        }
}

TEST(Recover, finds_an_anisotropic_distribution) {
    const Samples samples =
        measured(R"({"distribution": "gaussian", "sigma_x": 0.5, "sigma_y": 0.2})", 30000);
    ASSERT_FALSE(samples.isotropic);
    RecoverOptions options;
    options.evaluations = 200;
    const Recovered found = recover(device(), generator(), samples, options);
    EXPECT_GT(found.table.distribution.parts[0].table->width, 1U);
    EXPECT_LT(error_of(samples, found), 0.05 * size_of(samples));
}

// Against the data without their noise.
TEST(Recover, finds_two_widths_in_noisy_data) {
    const std::string spec = R"({"distribution": "mixture", "parts": [
        {"weight": 0.7, "distribution": "gaussian", "sigma": 0.08},
        {"weight": 0.3, "distribution": "gaussian", "sigma": 0.4}]})";
    const Distribution distribution = generator().weighted(parse_distribution(spec, "spec"));
    const Material truth = material_of(generator().generate(distribution, {400, false}, "spec"),
                                       0.4, {0.1, 0.3}, {0.8, 0.5});
    const Samples samples = synthesise(device(), truth, random_directions(12000, true, 4), 0.05, 1);
    ASSERT_TRUE(samples.isotropic);
    const Recovered found = recover(device(), generator(), samples, {});
    const Samples exact = synthesise(device(), truth, random_directions(12000, true, 4), 0, 1);
    EXPECT_LT(error_of(exact, found), 0.02 * size_of(exact));
}

// A mirror's peak that few samples see, and log p that must fall beyond it without a halo.
TEST(Recover, is_no_worse_than_models_on_sparse_narrow_peaks_and_falls_beyond_them) {
    for (const std::string model : {"ggx", "cook-torrance", "beckmann-smith"}) {
        Structure structure = structure_named(model, 1, "", true);
        Material material = typical_material(structure, 3);
        material.lobes[0].theta.back() = 0.02;
        const Samples samples =
            synthesise(device(), material, random_directions(1500, true, 2), 0.05, 1);
        const double fitted = fit(samples, structure).errors[0];
        const Recovered found = recover(device(), generator(), samples, {});
        const DeviceSamples packed = pack_samples(device(), samples, 80, Metric::Ngan);
        Material own = material_of(found.table, found.f0, found.kd, found.ks);
        own.channels = samples.channels;
        EXPECT_LT(
            value_errors(samples, packed.used, evaluate(device(), own, *samples.directions))[0],
            1.02 * fitted)
            << model;
        const DirectionTable& p = *found.table.distribution.parts[0].table;
        for (std::size_t i = 1; i < p.thetas.size(); ++i)
            EXPECT_LT(p.values[i], 1.2F * p.values[i - 1] + 1e-6F) << model << ' ' << p.thetas[i];
    }
}

TEST(Recover, tells_its_progress_which_only_grows) {
    const Samples samples = measured(R"({"distribution": "gaussian", "sigma": 0.3})", 1000);
    RecoverOptions options;
    std::vector<double> shares;
    options.progress = [&](double share) { shares.push_back(share); };
    recover(device(), generator(), samples, options);
    EXPECT_GT(shares.size(), 3U);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_EQ(shares.back(), 1);
}

TEST(Recover, refuses_what_reflects_nothing) {
    Samples samples = measured(R"({"distribution": "gaussian", "sigma": 0.3})", 1000);
    std::fill(samples.values.begin(), samples.values.end(), 0.0F);
    samples.source = "black.csv";
    try {
        recover(device(), generator(), samples, {});
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("black.csv"), std::string::npos);
    }
}

// value_errors must be what a fit reports of the same values.
TEST(Recover, errors_are_those_of_fits) {
    Structure structure = structure_named("kurt", 1, "", true);
    const Material material = typical_material(structure, 3);
    const Samples samples =
        synthesise(device(), material, random_directions(4000, true, 2), 0.2, 1);
    ProgramCache& cache = programs();
    FileFitter fitter(device(), cache, samples, {});
    const FitResult fit = fitter.fit(structure);
    const DeviceSamples packed = pack_samples(device(), samples, 80, Metric::Ngan);
    const MetricErrors errors =
        value_errors(samples, packed.used, evaluate(device(), fit.material, *samples.directions));
    for (std::size_t m = 0; m < errors.size(); ++m)
        EXPECT_NEAR(errors[m], fit.errors[m], 1e-4 * fit.errors[m]) << m;
}

} // namespace brdfit::test

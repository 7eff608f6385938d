// Materials of several lobes and channels equal the sum of their terms.

#include "host/evaluate/evaluate.hpp"
#include "tests/support/pairs.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>

namespace brdfit {

using namespace test;

namespace {

constexpr std::size_t many_channels = 31;

std::vector<double> random_strengths(Random& random, double upper) {
    std::vector<double> strengths;
    for (std::size_t i = 0; i < many_channels; ++i)
        strengths.push_back(static_cast<float>(uniform(random, 0, upper)));
    return strengths;
}

Material empty_material(Random& random, const Model& diffuse) {
    Material material;
    for (std::size_t i = 0; i < many_channels; ++i)
        material.channels.push_back(fmt::format("{} nm", 400 + 10 * i));
    material.diffuse = &diffuse;
    material.kd = random_strengths(random, 0.5);
    return material;
}

/// A lobe around its start; in the anisotropic form its roughnesses differ.
Lobe random_lobe(Random& random, const Model& model, bool isotropic) {
    Lobe lobe{&model, isotropic, {}, random_strengths(random, 1)};
    for (const Parameter& p : model.parameters(isotropic))
        lobe.theta.push_back(
            static_cast<float>(std::min(p.upper, p.start * uniform(random, 0.7, 1.5))));
    return lobe;
}

void compare_with_reference(const Material& material) {
    const std::vector<Pair> pairs = chosen_pairs();
    const std::vector<float> values = evaluate(device(), material, directions_of(pairs));
    ASSERT_EQ(values.size(), pairs.size() * material.channels.size());
    Mismatches mismatches;
    for (std::size_t k = 0; k < pairs.size(); ++k)
        for (std::size_t ch = 0; ch < material.channels.size(); ++ch) {
            const double value = values[ch * pairs.size() + k];
            const double reference = reference_evaluate(material, ch, pairs[k].wi, pairs[k].wo);
            if (reference > huge)
                mismatches.check(std::isfinite(value), "value", pairs[k], value, reference, 0);
            else
                mismatches.check_near(material.channels[ch], pairs[k], value, reference,
                                      relative_tolerance(reference) * reference + 1e-6);
        }
}

std::vector<const Model*> lobe_models() {
    std::vector<const Model*> models;
    for (const Model& model : catalogue())
        if (model.kind == Kind::Lobe)
            models.push_back(&model);
    return models;
}

} // namespace

TEST(Mixtures, equal_the_sum_of_their_terms) {
    Random random(5);
    const std::vector<const Model*> models = lobe_models();
    for (std::size_t first = 0; first < models.size(); ++first)
        for (const std::size_t lobes : {2, 4}) {
            Material material = empty_material(random, model_named("lambert"));
            for (std::size_t l = 0; l < lobes; ++l)
                material.lobes.push_back(random_lobe(
                    random, *models[(first + l * l) % models.size()], (first + l) % 2 == 0));
            SCOPED_TRACE(to_json(material)["lobes"].dump());
            compare_with_reference(material);
        }
}

// Lobes of one model share its planes.
TEST(Mixtures, repeat_one_model) {
    Random random(6);
    for (const Model* model : lobe_models())
        for (const bool isotropic : {true, false}) {
            SCOPED_TRACE(model->name);
            Material material = empty_material(random, model_named("lambert"));
            for (int l = 0; l < 3; ++l)
                material.lobes.push_back(random_lobe(random, *model, isotropic));
            compare_with_reference(material);
        }
}

// Every diffuse shape; one that goes with a lobe takes the first lobe's f0, not the second's.
TEST(Mixtures, have_every_diffuse_shape) {
    Random random(7);
    for (const Model& diffuse : catalogue()) {
        if (diffuse.kind == Kind::Lobe)
            continue;
        SCOPED_TRACE(diffuse.name);
        const Model& lobe = model_named(diffuse.lobe.empty() ? "ward" : diffuse.lobe);
        Material material = empty_material(random, diffuse);
        if (diffuse.lobe.empty())
            compare_with_reference(material); // without a lobe
        for (int l = 0; l < 2; ++l)
            material.lobes.push_back(random_lobe(random, lobe, l == 0));
        compare_with_reference(material);
        material.lobes.push_back(random_lobe(random, *lobe_models().back(), true));
        compare_with_reference(material);
    }
}

TEST(Mixtures, stay_finite_where_floats_end) {
    std::vector<Pair> pairs = special_pairs();
    pairs.push_back({{1, 0, 0}, {0, 0, 1}});
    pairs.push_back({{0, 0, -1}, {0, 0, -1}});
    for (const double strength : {0.0, 1.0, double{std::numeric_limits<float>::max()}})
        for (const Model* model : lobe_models()) {
            SCOPED_TRACE(fmt::format("{} with strength {}", model->name, strength));
            Material material;
            material.channels = {"Y"};
            material.diffuse = &model_named("lambert");
            material.kd = {strength};
            Lobe lobe{model, true, {}, {strength}};
            for (const Parameter& p : model->isotropic)
                lobe.theta.push_back(p.scale == Scale::Log ? p.lower : p.upper);
            material.lobes = {lobe, lobe};
            const std::vector<float> values = evaluate(device(), material, directions_of(pairs));
            for (std::size_t k = 0; k < pairs.size(); ++k) {
                const bool above = pairs[k].wi[2] > 0 && pairs[k].wo[2] > 0;
                EXPECT_TRUE(std::isfinite(values[k]) && values[k] >= 0) << values[k];
                EXPECT_TRUE((above && strength > 0) || values[k] == 0) << values[k];
            }
        }
}

} // namespace brdfit

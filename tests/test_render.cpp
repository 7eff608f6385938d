// Pictures by numbers: light and material samplers agree, furnaces show albedos, tables have the
// image's density.

#include "host/albedo/material.hpp"
#include "host/device/buffer.hpp"
#include "host/device/kernels.hpp"
#include "host/error.hpp"
#include "host/evaluate/measured.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/render/picture.hpp"
#include "host/render/renderer.hpp"
#include "tests/support/models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>

namespace {

using namespace brdfit;
using namespace brdfit::test;

Lobe lobe_of(const Model& model, double roughness) {
    Lobe lobe;
    lobe.model = &model;
    lobe.isotropic = true;
    lobe.ks = {0.5};
    for (const Parameter& p : model.isotropic) {
        const double width = p.scale == Scale::Log1p ? 2 / (roughness * roughness) : roughness;
        lobe.theta.push_back(std::clamp(p.width() ? width : p.start, p.lower, p.upper));
    }
    return lobe;
}

Scene sphere_under(Environment environment, std::size_t side) {
    Scene scene;
    scene.shapes = shapes_named("sphere", AROUND);
    scene.environment = std::move(environment);
    scene.view.width = scene.view.height = side;
    return scene;
}

/// A picture's mean over pixels and channels, with its standard error.
struct Whole {
    double mean, error;
};

Whole whole_of(const Film& film) {
    Whole whole{0, 0};
    for (std::size_t i = 0; i < film.pixels(); ++i)
        for (const Film::Plane plane : {Film::Red, Film::Green, Film::Blue}) {
            whole.mean += film.mean(plane, i);
            whole.error += std::pow(film.standard_error(plane, i), 2);
        }
    const double count = 3 * static_cast<double>(film.pixels());
    return {whole.mean / count, std::sqrt(3 * whole.error) / count}; // grey: channels go together
}

void expect_same(const Whole& a, const Whole& b, const std::string& what) {
    EXPECT_NEAR(a.mean, b.mean, 4 * std::hypot(a.error, b.error) + 1e-4 * a.mean) << what;
}

std::vector<float> pixels_of(const Film& film) {
    const Image image = image_of(film);
    std::vector<float> all;
    for (const std::vector<float>& plane : image.planes)
        all.insert(all.end(), plane.begin(), plane.end());
    return all;
}

class EveryModelRendered : public testing::TestWithParam<std::string> {};

} // namespace

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryModelRendered, testing::ValuesIn(lobe_model_names()),
                         test_name);

// Each way finds all of the light, or the means would differ.
TEST_P(EveryModelRendered, every_sampling_tends_to_the_same_picture) {
    const Renderer renderer(device(), material_of({lobe_of(model_named(GetParam()), 0.3)}, 0.1),
                            "material");
    Scene scene = sphere_under(soft_box_environment(), 24);
    scene.lights.push_back(light_from("rectangle:2,-3,2,1,1,20"));
    scene.lights.push_back(light_from("point:-2,-4,1,10"));
    RenderSettings settings;
    settings.samples = 512;
    settings.drawn = UNIFORM;
    const Whole uniform = whole_of(renderer.render(scene, settings));
    EXPECT_LT(uniform.error, 0.02 * uniform.mean);
    for (const strategy drawn : {BOTH, LIGHTS_ALONE, MATERIAL_ALONE}) {
        settings.drawn = drawn;
        expect_same(whole_of(renderer.render(scene, settings)), uniform,
                    "strategy " + std::to_string(drawn));
    }
}

TEST(Render, a_white_furnace_shows_the_albedo) {
    Material material = material_of({lobe_of(model_named("ggx"), 0.35)}, 0.2);
    constexpr std::size_t side = 48;
    const Scene scene = sphere_under(even_environment(), side);
    RenderSettings settings;
    settings.samples = 1024;
    const Film film = Renderer(device(), material, "material").render(scene, settings);
    AlbedoGrid grid;
    grid.thetas = 361;
    const Albedo table = albedo(device(), material, grid, 1e-4);
    const auto albedo_at = [&](double cosine) {
        const double at = std::acos(std::clamp(cosine, 0.0, 1.0)) / (pi / 2) * 360;
        const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), 359);
        const double s = at - static_cast<double>(i);
        return (1 - s) * table.values[0][i] + s * table.values[0][i + 1];
    };
    // R as a pixel shows it: the mean over a grid of rays.
    const Camera camera = camera_of(scene);
    std::size_t seen = 0, off = 0;
    double chi2 = 0;
    for (std::size_t pixel = 0; pixel < film.pixels(); ++pixel) {
        if (film.mean(Film::Covered, pixel) < 1)
            continue;
        double expected = 0;
        constexpr int fine = 8;
        bool all = true;
        for (int k = 0; k < fine * fine; ++k) {
            const double x = static_cast<double>(pixel % side) + (k % fine + 0.5) / fine;
            const double y = static_cast<double>(pixel / side) + (k / fine + 0.5) / fine;
            Vector d{};
            for (std::size_t c = 0; c < 3; ++c)
                d[c] = camera.corner[c] + x * camera.across[c] + y * camera.down[c];
            const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            double along = 0, at2 = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                along -= camera.at[c] * d[c] / length;
                at2 += camera.at[c] * camera.at[c];
            }
            // On the unit sphere cos theta_o is the half chord.
            const double half2 = 1 - (at2 - along * along);
            all = all && half2 > 0.01;
            expected += albedo_at(std::sqrt(std::max(0.0, half2))) / (fine * fine);
        }
        if (!all)
            continue;
        ++seen;
        const double error = std::max(film.standard_error(Film::Red, pixel), 2e-4);
        const double deviations = (film.mean(Film::Red, pixel) - expected) / error;
        chi2 += deviations * deviations;
        off += std::abs(film.mean(Film::Red, pixel) - expected) > 3 * error + 2e-3;
    }
    EXPECT_GT(seen, 1000U);
    EXPECT_LT(off, seen / 100); // 8 batches tell the error to a quarter
    EXPECT_LT(chi2 / static_cast<double>(seen), 2.5);
}

TEST(Render, weights_of_the_two_samplers_sum_to_one) {
    const cl::Program program = build_kernels(
        device(),
        "#define ROUGHNESSES 2\n" +
            kernel_texts({"base/common.cl", "base/direction_planes.h", "base/geometry.cl",
                          "terms/half_vectors.cl", "base/random.cl", "scene/scene_words.h",
                          "scene/shapes.cl", "scene/lights.cl"}) +
            "__kernel void weights(__global const real* a, __global const real* b, uint count, "
            "__global real* sum)\n{\n    FOR_EACH_OF_RUN(i, count)\n        sum[i] = "
            "shared_weight(a[i], b[i]) + shared_weight(b[i], a[i]);\n}\n",
        "weights");
    const auto width = static_cast<std::size_t>(device().form.vector_width);
    const std::size_t count = padded(4096, width);
    std::vector<float> a(count), b(count);
    for (std::size_t i = 0; i < count; ++i) {
        a[i] = std::pow(10.0F, static_cast<float>(i % 64) - 30);
        b[i] = std::pow(10.0F, static_cast<float>(i / 64) - 30);
    }
    const cl::Buffer left = upload(device(), a), right = upload(device(), b),
                     sums = make_buffer(device(), count * sizeof(float));
    cl::Kernel kernel(program, "weights");
    kernel.setArg(0, left);
    kernel.setArg(1, right);
    kernel.setArg(2, static_cast<cl_uint>(count / width));
    kernel.setArg(3, sums);
    enqueue_runs(device(), kernel, count / width);
    for (const float sum : download<float>(device(), sums, count))
        ASSERT_NEAR(sum, 1, 1e-6);
}

TEST(Render, the_alias_table_has_the_density_of_its_image) {
    const Environment sky = sky_environment();
    const AliasTable table = alias_table(sky);
    const std::size_t count = sky.texels.size();
    std::vector<double> share(count);
    constexpr double whole = 4294967295.0;
    for (std::size_t i = 0; i < count; ++i) {
        share[i] += table.own[i] / whole;
        share[table.other[i]] += 1 - table.own[i] / whole;
    }
    const Rgb flux = sky.flux();
    double density = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Rgb& texel = sky.texels[i];
        const double expected = (texel[0] + texel[1] + texel[2]) / (flux[0] + flux[1] + flux[2]);
        ASSERT_NEAR(table.density[i], expected, 1e-12 + 1e-9 * expected) << i;
        const double solid_angle = sky.solid_angle(i / sky.width);
        ASSERT_NEAR(share[i] / static_cast<double>(count), expected * solid_angle,
                    1e-12 + 1e-6 * expected * solid_angle)
            << i;
        density += table.density[i] * solid_angle;
    }
    EXPECT_NEAR(density, 1, 1e-9);
}

// A picture is a function of scene, material and seed: not of how the work is split.
TEST(Render, repeats_bit_for_bit) {
    const Material material = material_of({lobe_of(model_named("kurt"), 0.2)}, 0.1);
    Scene scene = sphere_under(sky_environment(), 40);
    scene.shapes = shapes_named("ground", AROUND);
    scene.view.theta = 70 * degree;
    RenderSettings settings;
    settings.samples = 40;
    settings.bounces = 2;
    const auto once = [&] {
        return pixels_of(Renderer(device(), material, "material").render(scene, settings));
    };
    const std::vector<float> first = once();
    EXPECT_EQ(first, once());
    settings.seed = 1;
    EXPECT_NE(first, once());
    if (has_sub_devices(device())) {
        settings.seed = 0;
        const Variable one("BRDFIT_UNITS", "1");
        EXPECT_EQ(first,
                  pixels_of(Renderer(open_device(), material, "material").render(scene, settings)));
    }
}

// A white sphere on white ground under an even sky shows 1, once light is followed far enough, and
// less before. Drawn by the material alone every path brings 1, or nothing where it is cut off.
TEST(Render, bounces_add_what_shapes_send_each_other) {
    const Material white = material_of({}, 1);
    Scene scene = sphere_under(even_environment(), 24);
    scene.shapes = shapes_named("ground", AROUND);
    scene.ground = {1, 1, 1};
    scene.view.theta = 60 * degree;
    const Renderer renderer(device(), white, "white");
    RenderSettings settings;
    settings.samples = 256;
    settings.drawn = MATERIAL_ALONE;
    double before = 0;
    for (const int bounces : {0, 1, 3, 24}) {
        settings.bounces = bounces;
        const Film film = renderer.render(scene, settings);
        const double mean = whole_of(film).mean;
        EXPECT_GT(mean, before);
        before = mean;
        if (bounces == 24) {
            for (std::size_t i = 0; i < film.pixels(); ++i)
                ASSERT_NEAR(film.mean(Film::Red, i), 1, 0.02) << i;
        }
    }
}

TEST(Render, a_measurement_shows_what_its_material_shows) {
    const Material material = material_of({lobe_of(model_named("ggx"), 0.4)}, 0.2);
    TemporaryFolder folder;
    Material rgb = material;
    rgb.channels = {"R", "G", "B"};
    rgb.kd = {0.2, 0.2, 0.2};
    rgb.lobes[0].ks = {0.5, 0.5, 0.5};
    write_material(rgb, folder / "m.json");
    ASSERT_EQ(run_program({"synth", folder / "m.json", folder / "m.binary"}).status, 0);
    const auto measured = std::make_shared<const MeasuredBrdf>(folder / "m.binary");
    Scene scene = sphere_under(soft_box_environment(), 20);
    RenderSettings settings;
    settings.samples = 128;
    settings.bounces = 1;
    scene.shapes = shapes_named("row:2", AROUND);
    const Film reference = Renderer(device(), rgb, "m").render(scene, settings);
    // By a proposal unlike it, too.
    for (const double roughness : {0.4, 0.15}) {
        const Material proposal = material_of({lobe_of(model_named("ward"), roughness)}, 0);
        const Film film = Renderer(device(), measured, proposal, "m").render(scene, settings);
        const Whole a = whole_of(reference), b = whole_of(film);
        EXPECT_NEAR(a.mean, b.mean, 4 * std::hypot(a.error, b.error) + 0.01 * a.mean) << roughness;
    }
}

TEST(Render, the_noise_is_as_large_as_it_says) {
    const Renderer renderer(device(), material_of({lobe_of(model_named("ggx"), 0.3)}, 0.1), "m");
    const Scene scene = sphere_under(soft_box_environment(), 24);
    RenderSettings settings;
    settings.samples = 4096;
    const Film fine = renderer.render(scene, settings);
    settings.samples = 64;
    settings.seed = 5;
    const Film coarse = renderer.render(scene, settings);
    double squares = 0, sum = 0, count = 0;
    for (std::size_t i = 0; i < fine.pixels(); ++i) {
        if (coarse.mean(Film::Covered, i) <= 0)
            continue;
        squares += std::pow(coarse.mean(Film::Red, i) - fine.mean(Film::Red, i), 2);
        sum += coarse.mean(Film::Red, i);
        ++count;
    }
    const double actual = std::sqrt(squares / count) / (sum / count);
    EXPECT_GT(coarse.noise(), 0.6 * actual);
    EXPECT_LT(coarse.noise(), 1.7 * actual);
    settings.samples = 65536;
    settings.tolerance = 0.02;
    const Film stopped = renderer.render(scene, settings);
    EXPECT_LE(stopped.noise(), 0.02);
    EXPECT_LT(stopped.samples(), 65536U);
}

TEST(Render, refuses_environments_that_are_none) {
    const TemporaryFolder folder;
    const auto written = [&](std::size_t width, std::size_t height, float first, float rest) {
        Image image;
        image.width = width;
        image.height = height;
        image.channels = {"R", "G", "B"};
        image.planes.assign(3, std::vector<float>(width * height, rest));
        image.planes[1][1] = first;
        write_exr(image, folder / "e.exr", ExrPixel::Float);
        return complaint([&] { read_environment(folder / "e.exr"); });
    };
    const float infinite = std::numeric_limits<float>::infinity();
    EXPECT_NE(written(4, 4, 1, 1).find("twice as wide as high"), std::string::npos);
    for (const float bad : {-1.0F, infinite, std::nanf(""), 1e31F})
        EXPECT_NE(written(8, 4, bad, 1).find("pixel (1, 0) is"), std::string::npos) << bad;
    EXPECT_NE(written(8, 4, 0, 0).find("black"), std::string::npos);
    EXPECT_EQ(written(8, 4, 2, 1), "");
    write_file(folder / "e.exr", "no picture");
    EXPECT_NE(complaint([&] { read_environment(folder / "e.exr"); }), "");
}

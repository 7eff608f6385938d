// BRDFs generated from distributions of normals: values against float64, reciprocity, energy,
// sampling, diffuse terms, Lambertian facets, and what a broken table says.

#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/image/image.hpp"
#include "host/microfacet/generator.hpp"
#include "host/model/material.hpp"
#include "tests/support/chi_square.hpp"
#include "tests/support/reference_microfacet.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>

namespace brdfit::test {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A folder with the table of each distribution, generated once.
class Tables {
  public:
    /// Path of the table.
    std::string path(const std::string& spec, std::size_t points = 200, bool facets = false) {
        const std::string key = spec + std::to_string(points) + (facets ? "f" : "");
        auto& known = paths_[key];
        if (known.empty()) {
            const Distribution distribution =
                generator().weighted(parse_distribution(spec, folder_ / "spec.json"));
            known = fmt::format("{}.exr", paths_.size());
            write_table(generator().generate(distribution, {points, facets}, "spec"),
                        folder_ / known);
        }
        return known;
    }
    const TemporaryFolder& folder() const { return folder_; }

  private:
    TemporaryFolder folder_;
    std::map<std::string, std::string> paths_;
};

Tables& tables() {
    static Tables all;
    return all;
}

Material parsed(const Json& json) {
    return parse_material(json.dump(), tables().folder() / "material.json");
}

Json material_json(const std::string& table, double f0, bool correlated = false) {
    return {{"brdfit", 1},
            {"channels", {"Y"}},
            {"diffuse", {{"model", "lambert"}, {"kd", {0}}}},
            {"lobes",
             {{{"model", "microfacet"},
               {"ks", {1}},
               {"f0", f0},
               {"table", table},
               {"correlated", correlated}}}}};
}

const std::string gauss = R"({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.2})";
const std::string round_gauss = R"({"distribution": "gaussian", "sigma": 0.3})";
const std::string grooves = R"({"distribution": "grooves"})";
const std::string satin = R"({"distribution": "satin"})";
const std::string velvet = R"({"distribution": "velvet"})";
const std::string slanted = R"({"distribution": "slanted-velvet"})";

/// A ramp and a bright square over the disk.
std::string image_spec() {
    const std::string path = tables().folder() / "pattern.exr";
    if (!std::filesystem::exists(path)) {
        Image image{64, 64, {"Y"}, {std::vector<float>(64 * 64)}, {}};
        for (std::size_t y = 0; y < 64; ++y)
            for (std::size_t x = 0; x < 64; ++x)
                image.planes[0][y * 64 + x] =
                    static_cast<float>(x) / 64 + (x > 30 && x < 50 && y > 10 && y < 30 ? 2 : 0);
        write_exr(image, path, ExrPixel::Float);
    }
    return R"({"distribution": "image", "image": "pattern.exr", "extent": 0.6,
               "base": {"distribution": "gaussian", "sigma": 0.3}})";
}

std::string tabulated_spec() {
    const std::string path = tables().folder() / "tabulated.csv";
    if (!std::filesystem::exists(path)) {
        std::string text = "theta_h,phi_h,p\n";
        for (int i = 0; i <= 24; ++i)
            for (int k = 0; k < 24; ++k) {
                const double theta = pi / 2 * i * i / 576, phi = 2 * pi * k / 24;
                text += fmt::format("{},{},{}\n", theta, phi,
                                    std::exp(-theta * theta / 0.1) * (1.5 + std::cos(phi)));
            }
        write_file(path, text);
    }
    return R"({"distribution": "tabulated", "file": "tabulated.csv"})";
}

const std::vector<std::string>& all_specs() {
    static const std::vector<std::string> specs{
        gauss, round_gauss, grooves, satin, velvet, slanted, image_spec(), tabulated_spec()};
    return specs;
}

std::vector<double> values_of(const Material& material, const Directions& directions) {
    const std::vector<float> values = evaluate(device(), material, directions);
    return {values.begin(), values.end()};
}

Directions one_by_one(const std::vector<std::pair<Vector, Vector>>& pairs) {
    Directions directions(pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k)
        directions.set(k, pairs[k].first, pairs[k].second);
    return directions;
}

Vector half_of(const Vector& wi, const Vector& wo, double& c) {
    Vector h{};
    for (std::size_t a = 0; a < 3; ++a)
        h[a] = wi[a] + wo[a];
    const double length = std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (double& x : h)
        x /= length;
    c = length / 2;
    return h;
}

/// P(wi, wo) / (iz oz <h.n>), Eq. 14 and 25.
double reference_shadowing(const Vector& wi, const Vector& wo, double height, double g_i,
                           double g_o, bool correlated) {
    const double p_i = wi[2] * height / g_i, p_o = wo[2] * height / g_o;
    double phi = std::atan2(wi[1], wi[0]) - std::atan2(wo[1], wo[0]);
    phi = std::remainder(phi, 2 * pi);
    const double t = correlated ? std::exp(-phi * phi / (2 * std::pow(15 * degree, 2))) : 0;
    return ((1 - t) * p_i * p_o + t * std::min(p_i, p_o)) / (wi[2] * wo[2] * height);
}

/// Integral over the hemisphere of a function of wi, on cells fine near the horizon.
template <typename F>
double over_hemisphere(const F& values, std::size_t steps = 96) {
    std::vector<Vector> directions;
    std::vector<double> weights;
    for (std::size_t i = 0; i < steps; ++i)
        for (std::size_t k = 0; k < 2 * steps; ++k) {
            const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(steps);
            const double phi = pi * (static_cast<double>(k) + 0.5) / static_cast<double>(steps);
            directions.push_back(direction(std::acos(z * z), phi));
            weights.push_back(2 * z * pi / static_cast<double>(steps * steps));
        }
    const std::vector<double> f = values(directions);
    double sum = 0;
    for (std::size_t k = 0; k < f.size(); ++k)
        sum += f[k] * directions[k][2] * weights[k];
    return sum;
}

double albedo(const Material& material, const Vector& wo) {
    return over_hemisphere([&](const std::vector<Vector>& wi) {
        Directions directions(wi.size());
        for (std::size_t k = 0; k < wi.size(); ++k)
            directions.set(k, wi[k], wo);
        return values_of(material, directions);
    });
}

std::size_t channel(const Image& image, const std::string& name) {
    return static_cast<std::size_t>(std::find(image.channels.begin(), image.channels.end(), name) -
                                    image.channels.begin());
}

} // namespace

// The interpolation of g is what the tolerance is for: 200 points.
TEST(Microfacet, has_the_values_of_eq_26_and_14) {
    const struct {
        std::string spec;
        ReferenceDistribution reference;
        double area_scale;
    } cases[] = {{gauss, reference_gaussian(0.1, 0.2), 1},
                 {round_gauss, reference_gaussian(0.3, 0.3), 1},
                 {satin,
                  reference_sum(0.7 / integrate_sphere(reference_gaussian(0.1, infinity),
                                                       [](const Vector&) { return 1.0; }),
                                reference_gaussian(0.1, infinity),
                                0.3 / integrate_sphere(reference_gaussian(0.3, infinity),
                                                       [](const Vector&) { return 1.0; }),
                                reference_gaussian(0.3, infinity)),
                  1},
                 {velvet, reference_velvet(0.5), 1},
                 {slanted, reference_gaussian(0.5, infinity, 50 * degree), 2}};
    std::vector<std::pair<Vector, Vector>> pairs;
    for (const double theta_i : {5.0, 60.0})
        for (const double theta_o : {33.0, 88.0})
            for (const double phi : {0.0, 10.0, 177.0})
                pairs.emplace_back(direction(theta_i * degree, 0.7),
                                   direction(theta_o * degree, 0.7 + phi * degree));
    const Directions directions = one_by_one(pairs);
    const double f0 = 0.3;
    for (const auto& one : cases) {
        const double height =
            one.area_scale * integrate_sphere(one.reference, [](const Vector& h) { return h[2]; });
        std::vector<double> areas_i, areas_o;
        for (const auto& [wi, wo] : pairs) {
            areas_i.push_back(reference_area(one.reference, wi));
            areas_o.push_back(reference_area(one.reference, wo));
        }
        // The interpolation's error falls with the grid's size.
        for (const auto& [points, tolerance] : {std::pair{std::size_t{200}, 1e-2}, {1000, 3e-4}})
            for (const bool correlated : {false, true}) {
                const Material material =
                    parsed(material_json(tables().path(one.spec, points), f0, correlated));
                const std::vector<double> values = values_of(material, directions);
                for (std::size_t k = 0; k < pairs.size(); ++k) {
                    const auto& [wi, wo] = pairs[k];
                    double c = 0;
                    const Vector h = half_of(wi, wo, c);
                    const double f =
                        one.reference.p(h) / 4 * (f0 + (1 - f0) * std::pow(1 - c, 5)) *
                        reference_shadowing(wi, wo, height, areas_i[k], areas_o[k], correlated);
                    EXPECT_NEAR(values[k], f, tolerance * f + 1e-12)
                        << one.spec << " " << points << " pair " << k;
                }
            }
    }
}

TEST(Microfacet, is_reciprocal_and_finite) {
    const auto random = random_directions(8000, false, 3);
    std::vector<std::pair<Vector, Vector>> pairs, swapped;
    for (std::size_t k = 0; k < random->count(); ++k) {
        pairs.push_back(random->pair(k));
        // Grazing ones too, down to the last bit above the horizon.
        if (k % 4 == 0)
            pairs.back().first = direction(pi / 2 - std::pow(10.0, -static_cast<double>(k % 7)), 1);
        swapped.emplace_back(pairs.back().second, pairs.back().first);
    }
    for (const Vector& z : {Vector{0, 0, 1}, Vector{1, 0, 1e-30}, Vector{0, -1, 1e-38}}) {
        pairs.emplace_back(z, Vector{0, 0, 1});
        swapped.emplace_back(Vector{0, 0, 1}, z);
    }
    for (const std::string& spec : all_specs())
        for (const bool correlated : {false, true}) {
            const Material material = parsed(material_json(tables().path(spec), 0.9, correlated));
            const std::vector<double> there = values_of(material, one_by_one(pairs));
            const std::vector<double> back = values_of(material, one_by_one(swapped));
            for (std::size_t k = 0; k < there.size(); ++k) {
                ASSERT_TRUE(std::isfinite(there[k]) && there[k] >= 0) << spec << k;
                ASSERT_NEAR(there[k], back[k], 1e-4 * there[k] + 1e-20) << spec << k;
            }
        }
}

TEST(Microfacet, samples_follow_their_density) {
    for (const std::string& spec : all_specs())
        expect_samples_follow_density(parsed(material_json(tables().path(spec), 0.9)), 100000);
    Json mixed = material_json(tables().path(gauss), 0.9);
    mixed["diffuse"] = {{"model", "microfacet"}, {"kd", {0.5}}};
    mixed["lobes"].push_back(material_json(tables().path(grooves), 0.5, true)["lobes"][0]);
    mixed["lobes"].push_back({{"model", "ward"}, {"ks", {0.2}}, {"m", 0.3}});
    expect_samples_follow_density(parsed(mixed), 100000);
}

TEST(Microfacet, sample_weights_have_the_mean_of_the_table) {
    for (const std::string& spec : all_specs())
        for (const bool correlated : {false, true}) {
            const Material material = parsed(material_json(tables().path(spec), 1, correlated));
            const MicrofacetTable& table = *material.lobes[0].table;
            for (const std::size_t row : {table.grid.rows / 3, table.grid.rows - 1}) {
                const std::size_t i = row * table.grid.columns + table.grid.columns / 3;
                const Vector wo = table.grid.direction(static_cast<double>(row),
                                                       static_cast<double>(i % table.grid.columns));
                const DirectionSamples samples =
                    sample_material(device(), material, wo, 200000, 5, Sequence::Sobol);
                double sum = 0, squares = 0;
                for (const float w : samples.weights) {
                    sum += w;
                    squares += double{w} * w;
                }
                const double n = 200000, mean = sum / n;
                const double r = table.reflectance(1, correlated)[i];
                EXPECT_NEAR(mean, r, 5e-3 * r + 4 * std::sqrt((squares / n - mean * mean) / n))
                    << spec << correlated << " " << row;
            }
        }
}

TEST(Microfacet, diffuse_term_returns_what_the_lobe_leaves) {
    for (const std::string& spec : {round_gauss, gauss})
        for (const bool metal : {false, true})
            for (const double f0 : {0.05, 0.9}) {
                Json json = material_json(tables().path(spec, 1000), f0);
                json["lobes"][0]["ks"] = {0};
                json["diffuse"] = {{"model", "microfacet"}, {"kd", {1}}, {"metal", metal}};
                const Material material = parsed(json);
                const MicrofacetTable& table = *material.lobes[0].table;
                const auto row = static_cast<double>(table.grid.rows) / 2;
                const Vector wo = table.grid.direction(row, 0);
                const double r = (1 - f0) * interpolate(table.grid, table.r0, row, 0) +
                                 f0 * interpolate(table.grid, table.r1, row, 0);
                // rho_d = 1, of a metal f0.
                const double left = metal ? f0 * std::max(0.0, f0 - r) : 1 - r;
                // A metal at low f0 reflects more than f0 at most angles: nothing may be left.
                EXPECT_NEAR(albedo(material, wo), left, 2e-3 * left + 2e-5) << spec << metal << f0;
                const Directions pair = one_by_one(
                    {{direction(1, 2), direction(0.3, 1)}, {direction(0.3, 1), direction(1, 2)}});
                const std::vector<double> values = values_of(material, pair);
                EXPECT_NEAR(values[0], values[1], 1e-6 * values[0]);
            }
}

TEST(Microfacet, lambertian_facets_have_eq_33_and_retro_reflection) {
    const std::string spec = R"({"distribution": "gaussian", "sigma": 1})";
    const ReferenceDistribution reference = reference_gaussian(1, 1);
    const double height = integrate_sphere(reference, [](const Vector& h) { return h[2]; });
    for (const bool correlated : {false, true}) {
        Json json = material_json(tables().path(spec, 200, true), 0, correlated);
        json["lobes"][0]["model"] = "microfacet-lambertian";
        json["lobes"][0].erase("f0");
        const Material material = parsed(json);
        std::vector<std::pair<Vector, Vector>> pairs;
        for (const double theta_i : {10.0, 60.0, 85.0})
            for (const double theta_o : {0.0, 45.0, 80.0})
                for (const double phi : {0.0, 20.0, 90.0, 180.0})
                    pairs.emplace_back(direction(theta_i * degree, 0.3),
                                       direction(theta_o * degree, 0.3 + phi * degree));
        const std::vector<double> values = values_of(material, one_by_one(pairs));
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            const auto& [wi, wo] = pairs[k];
            const double facets =
                integrate_facing(reference, wi, [&, i = wi, o = wo](const Vector& h) {
                    const double to_o = h[0] * o[0] + h[1] * o[1] + h[2] * o[2];
                    return (h[0] * i[0] + h[1] * i[1] + h[2] * i[2]) * std::max(0.0, to_o);
                });
            const double f = facets / pi *
                             reference_shadowing(wi, wo, height, reference_area(reference, wi),
                                                 reference_area(reference, wo), correlated);
            EXPECT_NEAR(values[k], f, 3e-3 * f) << k;
        }
        // Oren and Nayar 1994: brightest where light comes from the viewer, and not Lambertian.
        const std::vector<double> around =
            values_of(material, one_by_one({{direction(1, 0), direction(1, 0)},
                                            {direction(1, 0), direction(1, pi / 2)},
                                            {direction(1, 0), direction(1, pi)}}));
        EXPECT_GT(around[0], 1.5 * around[2]);
        EXPECT_GT(around[0], 1.2 * around[1]);
        EXPECT_LE(albedo(material, direction(1, 0)), 1);
    }
}

TEST(Microfacet, correlated_shadowing_raises_retro_reflection) {
    const Directions back = one_by_one({{direction(1, 0.5), direction(1.2, 0.5)}});
    for (const std::string& spec : {velvet, round_gauss, grooves}) {
        const double correlated =
            values_of(parsed(material_json(tables().path(spec), 1, true)), back)[0];
        const double independent =
            values_of(parsed(material_json(tables().path(spec), 1, false)), back)[0];
        EXPECT_GT(correlated, spec == velvet ? 1.1 * independent : independent) << spec;
    }
}

TEST(Microfacet, material_comes_back_from_its_file) {
    Json json = material_json(tables().path(gauss), 0.25, true);
    json["diffuse"] = {{"model", "microfacet"}, {"kd", {0.5}}, {"metal", true}};
    const Material material = parsed(json);
    EXPECT_EQ(to_json(material), json);
    EXPECT_FALSE(material.isotropic());
    EXPECT_TRUE(parsed(material_json(tables().path(round_gauss), 0.25)).isotropic());
    const MicrofacetTable& table = *material.lobes[0].table;
    EXPECT_EQ(table.distribution.name, "gaussian");
    EXPECT_DOUBLE_EQ(table.distribution.parts[0].sigma_y, 0.2);
    // Infinite widths, images and tables survive.
    EXPECT_TRUE(std::isinf(
        read_table(tables().folder() / tables().path(satin))->distribution.parts[0].sigma_y));
    EXPECT_EQ(read_table(tables().folder() / tables().path(tabulated_spec()))
                  ->distribution.parts[0]
                  .table->thetas.size(),
              25U);
}

TEST(Microfacet, broken_materials_and_tables_say_what_is_wrong) {
    const std::string good = tables().path(round_gauss);
    const auto says = [](const Json& json, const std::string& text) {
        const std::string message = complaint<std::runtime_error>([&] { parsed(json); });
        EXPECT_NE(message.find(text), std::string::npos) << message;
        EXPECT_NE(message.find("material.json: "), std::string::npos) << message;
    };
    Json json = material_json("moved.exr", 0.5);
    says(json, "lobes[0].table");
    says(json, "moved.exr");
    json = material_json(good, 0.5);
    json["lobes"][0].erase("table");
    says(json, "lobes[0].table: is missing");
    json = material_json(good, 0.5);
    json["lobes"][0]["correlated"] = 1;
    says(json, "lobes[0].correlated: is 1; expected true or false");
    json = material_json(good, 0.5);
    json["lobes"][0]["tabel"] = "x";
    says(json, "lobes[0].tabel: is an unknown key");
    json = material_json(good, 2);
    says(json, "lobes[0].f0");
    json = material_json(good, 0.5);
    json["lobes"][0]["model"] = "microfacet-lambertian";
    json["lobes"][0].erase("f0");
    says(json, "Lambertian facets");
    json = material_json(good, 0.5);
    json["diffuse"] = {{"model", "microfacet"}, {"kd", {1}}};
    json["lobes"] = Json::array();
    says(json, "first lobe of microfacet");
    json = material_json(good, 0.5);
    json["diffuse"]["metal"] = true;
    says(json, "diffuse.metal: is an unknown key");
}

TEST(Microfacet, broken_table_files_say_what_is_wrong) {
    const TemporaryFolder folder;
    const std::vector<Image> parts = read_exr_parts(tables().folder() / tables().path(gauss));
    const auto says = [&](const std::function<void(std::vector<Image>&)>& breaks,
                          const std::string& text) {
        std::vector<Image> broken = parts;
        breaks(broken);
        const std::string path = folder / "broken.exr";
        write_exr_parts(broken, path, ExrPixel::Float);
        const std::string message = complaint<std::runtime_error>([&] { read_table(path); });
        EXPECT_NE(message.find(text), std::string::npos) << message;
        EXPECT_NE(message.find(path), std::string::npos) << message;
    };
    says([](auto& p) { p[0].channels[channel(p[0], "g")] = "h"; }, "g is missing");
    says([](auto& p) { p[0].planes[channel(p[0], "g")][3] = std::nanf(""); }, "channel g is nan");
    says([](auto& p) { p[0].planes[channel(p[0], "R0")][3] = -1; }, "channel R0 is -1");
    says([](auto& p) { p[0].metadata.erase("microfacet"); }, "has no attribute microfacet");
    says([](auto& p) { p[0].metadata["microfacet"] = "{"; }, "is no JSON");
    says([](auto& p) { p[0].metadata["microfacet"] = "{\"version\": 2}"; }, "version: is 2");
    says([](auto& p) { p.erase(p.begin() + 1); }, "has no part sampling.0");
    says(
        [](auto& p) {
            auto& mass = p[1].planes[channel(p[1], "mass")];
            std::fill(mass.begin(), mass.end(), 0.0F);
        },
        "positive mass");
    says(
        [](auto& p) {
            p[0].width = 1;
            for (auto& plane : p[0].planes)
                plane.resize(p[0].height);
        },
        "4 columns");
    says([](auto& p) { p[0].metadata["name"] = "other"; }, "has no part tables");
    // Every truncation is an error, whatever it cuts.
    const std::string bytes = read_file(tables().folder() / tables().path(gauss));
    for (std::size_t length = 1; length < bytes.size(); length += bytes.size() / 97) {
        write_file(folder / "short.exr", bytes.substr(0, length));
        EXPECT_NE(complaint<std::runtime_error>([&] { read_table(folder / "short.exr"); }), "")
            << length;
    }
}

// The form of kernels for GPUs finds the same.
TEST(Microfacet, tables_do_not_depend_on_the_form) {
    Device other = device();
    other.form.vector_width = 1;
    other.form.local_size = 16;
    other.form.block = 1024;
    const Distribution distribution = generator().weighted(parse_distribution(gauss, "spec"));
    const MicrofacetTable there = Generator(other).generate(distribution, {32, false}, "spec");
    const MicrofacetTable here = generator().generate(distribution, {32, false}, "spec");
    for (std::size_t i = 0; i < here.g.size(); ++i) {
        EXPECT_NEAR(there.g[i], here.g[i], 1e-5 * here.g[i]);
        EXPECT_NEAR(there.r1_correlated[i], here.r1_correlated[i], 1e-4);
    }
    const Material material = parsed(material_json(tables().path(gauss), 0.3));
    const auto directions = random_directions(2000, false, 9);
    const std::vector<float> a = evaluate(device(), material, *directions);
    const std::vector<float> b = evaluate(other, material, *directions);
    for (std::size_t k = 0; k < a.size(); ++k)
        ASSERT_NEAR(a[k], b[k], 1e-4F * a[k] + 1e-12F) << k;
}

} // namespace brdfit::test

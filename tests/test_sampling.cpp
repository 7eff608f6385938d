// What must hold for the sampler of every lobe model of the catalogue: samples follow the density,
// their weights give the albedo, and with less noise than blind sampling. A new model is covered
// without being named here.

#include "host/device/buffer.hpp"
#include "host/device/kernels.hpp"
#include "host/error.hpp"
#include "host/evaluate/sample.hpp"
#include "host/files/npy.hpp"
#include "host/model/structure.hpp"
#include "tests/support/chi_square.hpp"
#include "tests/support/hemisphere.hpp"
#include "tests/support/models.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <set>
#include <sstream>

namespace brdfit::test {

namespace {

/// A lobe of roughness `across` along y and `along` along x; an exponent n stands for sqrt(2 / n).
/// The other parameters are typical.
Lobe lobe_of(const Model& model, bool isotropic, double along, double across) {
    Lobe lobe{&model, isotropic, {}, {1}};
    bool first = true;
    for (const Parameter& p : model.parameters(isotropic)) {
        double value = p.start * (1 - 0.1 * static_cast<double>(lobe.theta.size()));
        if (p.width()) {
            const double roughness = first ? along : across;
            value = p.scale == Scale::Log ? roughness : 2 / (roughness * roughness);
            first = false;
        }
        lobe.theta.push_back(static_cast<float>(std::clamp(value, p.lower, p.upper)));
    }
    return lobe;
}

struct Moments {
    double mean, variance;
    std::size_t count;
    double standard_error() const { return std::sqrt(variance / static_cast<double>(count)); }
};

Moments moments(const DirectionSamples& samples, std::size_t channel = 0) {
    const std::size_t n = samples.count();
    const float* const weight = samples.weight(channel);
    double sum = 0, squares = 0;
    for (std::size_t k = 0; k < n; ++k) {
        sum += weight[k];
        squares += double{weight[k]} * weight[k];
    }
    const double mean = sum / static_cast<double>(n);
    return {mean, std::max(0.0, squares / static_cast<double>(n) - mean * mean), n};
}

/// Integral of (f iz)^power / (density of cosine sampling)^(power - 1) by the float64 reference.
double cosine_moment(const Material& material, const Vector& wo, int power,
                     const std::vector<Vector>& hints, double tolerance) {
    return Hemisphere(
               [&](const std::vector<Vector>& directions) {
                   std::vector<double> values;
                   for (const Vector& wi : directions)
                       values.push_back(
                           std::pow(reference_evaluate(material, 0, wi, wo) * pi, power) * wi[2] /
                           pi);
                   return values;
               },
               tolerance, hints)
        .integral();
}

std::vector<std::string> conserving_lobe_names() {
    return model_names([](const Model& m) { return m.kind == Kind::Lobe && m.conserves_energy; });
}

class EverySampler : public testing::TestWithParam<std::string> {
  protected:
    const Model& model = model_named(GetParam());
};
class ConservingSampler : public EverySampler {};

} // namespace

INSTANTIATE_TEST_SUITE_P(Catalogue, EverySampler, testing::ValuesIn(lobe_model_names()), test_name);
INSTANTIATE_TEST_SUITE_P(Catalogue, ConservingSampler, testing::ValuesIn(conserving_lobe_names()),
                         test_name);

TEST_P(EverySampler, follows_its_density) {
    for (const double roughness : {0.7, 0.1, 0.005})
        expect_samples_follow_density(material_of({lobe_of(model, true, roughness, roughness)}, 0),
                                      200000);
}

TEST_P(EverySampler, follows_its_density_anisotropic) {
    expect_samples_follow_density(material_of({lobe_of(model, false, 0.5, 0.01)}, 0), 200000);
    expect_samples_follow_density(material_of({lobe_of(model, false, 0.1, 0.4)}, 0), 200000);
}

TEST_P(EverySampler, follows_its_density_in_mixtures) {
    const std::vector<std::string> names = lobe_model_names();
    const auto place = std::find(names.begin(), names.end(), model.name) - names.begin();
    const Model& next = model_named(names[static_cast<std::size_t>(place + 1) % names.size()]);
    expect_samples_follow_density(
        material_of({lobe_of(model, true, 0.1, 0.1), lobe_of(next, false, 0.3, 0.6)}, 0.3), 200000);
}

TEST_P(EverySampler, estimates_the_albedo) {
    for (const double roughness : {0.1, 0.5})
        for (const double kd : {0.0, 0.4})
            for (const double theta : {5.0, 60.0}) {
                const Material material =
                    material_of({lobe_of(model, false, roughness, 0.8 * roughness)}, kd);
                SCOPED_TRACE(fmt::format("{} kd {} from {} degrees",
                                         to_json(material)["lobes"].dump(), kd, theta));
                const Vector wo = direction(theta * degree, 1);
                const Sampler sampler(device(), material);
                const DirectionSamples samples = sampler.sample(wo, 200000, 3, Sequence::Philox);
                const std::vector<Vector> hints = hints_of(above(samples));
                const double albedo = cosine_moment(material, wo, 1, hints, 1e-6);
                const Moments found = moments(samples);
                const double tolerance = far_off * found.standard_error() + 1e-4 * albedo;
                EXPECT_NEAR(found.mean, albedo, tolerance);
                EXPECT_LT(tolerance, 0.03 * albedo);
                const Moments even = moments(sampler.sample(wo, 1 << 17, 3, Sequence::Sobol));
                EXPECT_NEAR(even.mean, albedo, far_off * even.standard_error() / 4 + 2e-4 * albedo);
                if (roughness == 0.1 && kd == 0) {
                    const double squares = cosine_moment(material, wo, 2, hints, 1e-5 * albedo);
                    EXPECT_LT(10 * found.variance, squares - albedo * albedo);
                }
            }
}

TEST_P(ConservingSampler, reflects_no_more_than_it_receives) {
    for (const double roughness : {0.002, 0.05, 0.3, 1.0, 2.0})
        for (const double ratio : {1.0, 0.2}) {
            Lobe lobe = lobe_of(model, false, roughness, roughness * ratio);
            if (model.fresnel())
                lobe.theta[0] = 1;
            const Sampler sampler(device(), material_of({lobe}, 0));
            for (const double theta : {0.0, 50.0, 80.0, 89.0}) {
                const Moments found = moments(
                    sampler.sample(direction(theta * degree, 0.5), 1 << 15, 5, Sequence::Sobol));
                EXPECT_LE(found.mean, 1 + 1e-3 + far_off * found.standard_error())
                    << roughness << " " << ratio << " " << theta;
            }
        }
}

TEST(Sampler, follows_its_density_without_lobes) {
    expect_samples_follow_density(material_of({}, 0.5), 200000);
}

TEST(Sampler, weighs_every_channel_and_coupled_diffuse_shapes) {
    for (const Model& diffuse : catalogue()) {
        if (diffuse.kind != Kind::DiffuseAndLobe)
            continue;
        SCOPED_TRACE(diffuse.name);
        Lobe lobe = lobe_of(model_named(diffuse.lobe), true, 0.3, 0.3);
        lobe.ks = {0, 0.2, 1};
        Material material = material_of({lobe}, 0);
        material.channels = {"a", "b", "c"};
        material.kd = {0.5, 0.1, 0};
        material.diffuse = &diffuse;
        const Vector wo = direction(40 * degree, 2);
        const DirectionSamples samples =
            sample_material(device(), material, wo, 100000, 11, Sequence::Philox);
        for (std::size_t ch = 0; ch < 3; ++ch) {
            Material one = material;
            one.kd = {material.kd[ch]};
            one.lobes[0].ks = {lobe.ks[ch]};
            const Moments found = moments(samples, ch);
            EXPECT_NEAR(found.mean, cosine_moment(one, wo, 1, hints_of(above(samples)), 1e-6),
                        far_off * found.standard_error() + 1e-4);
        }
    }
}

TEST(Sampler, stays_finite_where_floats_end) {
    for (const std::string& name : lobe_model_names())
        for (const double fraction : {0.0, 1.0}) {
            const Model& model = model_named(name);
            Lobe lobe{&model, false, {}, {3e38}};
            for (const Parameter& p : model.anisotropic)
                lobe.theta.push_back(fraction > 0 ? p.upper : p.lower);
            const Sampler sampler(device(), material_of({lobe}, 0));
            for (const double theta : {0.0, 45.0, 89.99, 89.9999}) {
                const DirectionSamples samples =
                    sampler.sample(direction(theta * degree, 0.1), 5000, 1, Sequence::Sobol);
                for (std::size_t k = 0; k < samples.count(); ++k)
                    ASSERT_TRUE(std::isfinite(samples.wi_z[k]) && std::isfinite(samples.pdf[k]) &&
                                std::isfinite(samples.weights[k]) && samples.weights[k] >= 0 &&
                                samples.pdf[k] >= 0)
                        << name << " " << fraction << " " << theta << " sample " << k << ": wi.z "
                        << samples.wi_z[k] << " pdf " << samples.pdf[k] << " weight "
                        << samples.weights[k];
            }
        }
}

TEST(Sampler, black_materials_weigh_nothing) {
    const DirectionSamples samples =
        sample_material(device(), material_of({}, 0), direction(0.5, 0), 1000, 1, Sequence::Sobol);
    EXPECT_EQ(moments(samples).mean, 0);
    EXPECT_GT(samples.pdf[0], 0);
}

TEST(Sampler, sample_depends_on_seed_and_index_alone) {
    const Material material =
        material_of({lobe_of(model_named(lobe_model_names()[0]), false, 0.2, 0.4)}, 0.2);
    const Vector wo = direction(0.7, 0.2);
    Device small = device(); // many short passes
    small.max_allocation = 1 << 16;
    Device narrow = device();
    narrow.form = {1, 1, 2048, 1};
    for (const Sequence sequence : {Sequence::Philox, Sequence::Sobol}) {
        const auto draw = [&](const Device& on, std::size_t n, std::uint64_t seed) {
            return sample_material(on, material, wo, n, seed, sequence);
        };
        const DirectionSamples many = draw(device(), 20000, 5), few = draw(device(), 777, 5),
                               passes = draw(small, 20000, 5), scalar = draw(narrow, 20000, 5),
                               other = draw(device(), 777, 6),
                               far = draw(device(), 777, (std::uint64_t{1} << 32) + 5);
        EXPECT_TRUE(std::equal(few.wi_x.begin(), few.wi_x.end(), many.wi_x.begin()));
        EXPECT_TRUE(std::equal(few.weights.begin(), few.weights.end(), many.weights.begin()));
        EXPECT_EQ(passes.wi_x, many.wi_x);
        EXPECT_EQ(passes.pdf, many.pdf);
        EXPECT_EQ(passes.weights, many.weights);
        std::size_t same = 0;
        for (std::size_t k = 0; k < many.count(); ++k)
            same += std::abs(scalar.wi_x[k] - many.wi_x[k]) < 1e-4 &&
                    std::abs(scalar.wi_z[k] - many.wi_z[k]) < 1e-4;
        EXPECT_GE(same + 5, many.count()); // a component may be drawn on the edge
        EXPECT_NE(other.wi_x, few.wi_x);
        EXPECT_NE(far.wi_x, few.wi_x);
    }
}

TEST(Sampler, refuses_what_is_no_viewer) {
    const Sampler sampler(device(), material_of({}, 1));
    for (const Vector& wo : std::vector<Vector>{{0, 0, 0}, {0, 0, -1}, {1, 0, 0}, {0, 1, 1}})
        EXPECT_THROW(sampler.sample(wo, 10, 1, Sequence::Sobol), UsageError);
    EXPECT_THROW(sampler.sample({0, 0, 1}, 0, 1, Sequence::Sobol), UsageError);
}

namespace {

/// Words that kernels/base/random.cl makes: `body` sets x[0..3] for the item `i`.
std::vector<cl_uint> random_words(const std::string& body, std::size_t items) {
    std::string text = "#define V 1\n#define LS 1\n" + kernel_source("base/common.cl") +
                       kernel_source("base/random.cl") +
                       "__kernel void words(__global uint* out) {\n"
                       "    const uint i = get_global_id(0);\n    uint x[4] = {0u, 0u, 0u, 0u};\n" +
                       body +
                       "    for (int k = 0; k < 4; ++k)\n        out[4 * i + k] = x[k];\n}\n";
    cl::Program program(device().context, text);
    program.build(device().handle, "-cl-std=CL1.2");
    cl::Kernel kernel(program, "words");
    const cl::Buffer out = make_buffer(device(), items * 4 * sizeof(cl_uint), CL_MEM_READ_WRITE);
    kernel.setArg(0, out);
    device().queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(1));
    return download<cl_uint>(device(), out, items * 4);
}

} // namespace

// Salmon et al. 2011, the known answers of their Random123.
TEST(Random, philox_gives_its_known_answers) {
    const auto philox = [](const std::vector<cl_uint>& counter, cl_uint key0, cl_uint key1) {
        std::string body;
        for (std::size_t k = 0; k < 4; ++k)
            body += fmt::format("x[{}] = {}u;\n", k, counter[k]);
        return random_words(body + fmt::format("philox(x, {}u, {}u);\n", key0, key1), 1);
    };
    using Words = std::vector<cl_uint>;
    constexpr cl_uint ones = 0xffffffff;
    EXPECT_EQ(philox({0, 0, 0, 0}, 0, 0), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
    EXPECT_EQ(philox({ones, ones, ones, ones}, ones, ones),
              (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
    EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0xa4093822, 0x299f31d0),
              (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// The first two dimensions are a (0, 2)-sequence, each alone a (0, 1)-sequence, however scrambled:
// 2^10 consecutive points have one point in each elementary interval.
TEST(Random, sobol_points_fill_elementary_intervals) {
    constexpr unsigned bits = 10;
    constexpr std::size_t points = std::size_t{1} << bits;
    for (const unsigned seed : {0u, 1u, 0xdeadbeefu}) {
        const std::vector<cl_uint> words = random_words(
            fmt::format("x[0] = sobol_0(i, {0}u); x[1] = sobol_1(i, {0}u + 1u); x[2] = "
                        "sobol_2(i, {0}u + 2u);\n",
                        seed),
            4 * points);
        for (std::size_t first = 0; first < 4 * points; first += points) {
            for (unsigned split = 0; split <= bits; ++split) {
                std::set<cl_uint> cells;
                for (std::size_t k = first; k < first + points; ++k) {
                    const std::uint64_t x = words[4 * k], y = words[4 * k + 1];
                    cells.insert(static_cast<cl_uint>(((x >> (32 - split)) << (bits - split)) |
                                                      (y >> (32 - bits + split))));
                }
                EXPECT_EQ(cells.size(), points) << seed << " " << split;
            }
            std::set<cl_uint> third;
            for (std::size_t k = first; k < first + points; ++k)
                third.insert(words[4 * k + 2] >> (32 - bits));
            EXPECT_EQ(third.size(), points) << seed;
        }
    }
}

namespace {

const char* const mixed_material =
    R"({"brdfit": 1, "channels": ["R", "G"], "diffuse": {"model": "lambert", "kd": [0.1, 0.2]},
    "lobes": [{"model": "kurt", "ks": [0.5, 0.4], "f0": 0.5, "mx": 0.2, "my": 0.1, "alpha": 0.1}]})";

/// Rows of numbers of a CSV file below its heading, and the heading.
std::vector<std::vector<double>> rows_of(const std::string& path, std::string& heading) {
    std::istringstream text(read_file(path));
    std::vector<std::vector<double>> rows;
    heading.clear();
    for (std::string line; std::getline(text, line);) {
        if (line.empty() || line[0] == '#')
            continue;
        if (heading.empty()) {
            heading = line;
            continue;
        }
        rows.emplace_back();
        std::istringstream fields(line);
        for (std::string field; std::getline(fields, field, ',');)
            rows.back().push_back(std::stod(field));
    }
    return rows;
}

} // namespace

TEST(SampleCommand, writes_samples_whose_density_pdf_confirms) {
    const TemporaryFolder folder;
    const std::string material = folder / "m.json", samples = folder / "s.csv",
                      directions = folder / "d.csv", pdf = folder / "p.csv";
    write_file(material, mixed_material);
    const Outcome drawn = run_program(
        {"sample", material, "--wo", "60,30", "-n", "2000", "--seed", "4", "-o", samples});
    ASSERT_EQ(drawn.status, 0) << drawn.err;
    std::string heading;
    const auto rows = rows_of(samples, heading);
    EXPECT_EQ(heading, "wi_x,wi_y,wi_z,pdf,weight_R,weight_G");
    ASSERT_EQ(rows.size(), 2000);
    const Vector wo = direction(60 * degree, 30 * degree);
    std::string text = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n";
    for (const auto& row : rows)
        text += fmt::format("{},{},{},{},{},{}\n", row[0], row[1], row[2], wo[0], wo[1], wo[2]);
    write_file(directions, text);
    const Outcome asked = run_program({"pdf", material, directions, "-o", pdf});
    ASSERT_EQ(asked.status, 0) << asked.err;
    const auto densities = rows_of(pdf, heading);
    EXPECT_EQ(heading, "pdf");
    ASSERT_EQ(densities.size(), rows.size());
    const Material parsed = parse_material(mixed_material, "m.json");
    for (std::size_t k = 0; k < rows.size(); ++k) {
        EXPECT_NEAR(densities[k][0], rows[k][3], 1e-3 * rows[k][3] + 1e-5);
        for (std::size_t ch = 0; ch < 2 && rows[k][3] > 0; ++ch) {
            const Vector wi = {rows[k][0], rows[k][1], rows[k][2]};
            const double weight = reference_evaluate(parsed, ch, wi, wo) * wi[2] / rows[k][3];
            EXPECT_NEAR(rows[k][4 + ch], weight, 1e-3 * weight + 1e-5);
        }
    }
}

TEST(SampleCommand, does_not_depend_on_threads) {
    const TemporaryFolder folder;
    const std::string material = folder / "m.json";
    write_file(material, mixed_material);
    for (const std::string sequence : {"sobol", "philox"}) {
        const std::string one = folder / "1.npy", all = folder / "2.npy";
        std::vector<std::string> arguments = {"sample", material,     "--wo",   "10,0", "-n",
                                              "30000",  "--sequence", sequence, "-o",   one};
        ASSERT_EQ(run_program(arguments, {"POCL_MAX_PTHREAD_COUNT=1"}).status, 0);
        arguments.back() = all;
        ASSERT_EQ(run_program(arguments).status, 0);
        EXPECT_EQ(read_file(one), read_file(all));
    }
}

// More than a pass of the sampler.
TEST(SampleCommand, writes_in_pieces_what_the_sampler_gives_at_once) {
    const TemporaryFolder folder;
    const std::string material = folder / "m.json", out = folder / "s.npy";
    write_file(material, mixed_material);
    constexpr std::size_t n = 300007;
    ASSERT_EQ(run_program({"sample", material, "--wo", "40,20", "-n", std::to_string(n), "--seed",
                           "3", "-o", out})
                  .status,
              0);
    const DirectionSamples whole =
        sample_material(device(), read_material(material), direction(40 * degree, 20 * degree), n,
                        3, Sequence::Sobol);
    const MappedFile file(out);
    const npy::Array table = npy::read(file);
    ASSERT_EQ(table.rows, n);
    ASSERT_EQ(table.columns, 6U);
    for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(table.at(i, 0), whole.wi_x[i]) << i;
        ASSERT_EQ(table.at(i, 3), whole.pdf[i]) << i;
        ASSERT_EQ(table.at(i, 4), whole.weight(0)[i]) << i;
    }
}

TEST(SampleCommand, draws_for_every_viewer_of_a_file) {
    const TemporaryFolder folder;
    const std::string material = folder / "m.json", viewers = folder / "v.csv";
    write_file(material, mixed_material);
    const Vector second = direction(40 * degree, 20 * degree);
    write_file(viewers,
               fmt::format("wo_x,wo_y,wo_z\n0,0,1\n{},{},{}\n", second[0], second[1], second[2]));
    ASSERT_EQ(run_program({"sample", material, "--wo", viewers, "-n", "5", "-o", folder / "s.npy"})
                  .status,
              0);
    const MappedFile file(folder / "s.npy");
    const npy::Array table = npy::read(file);
    ASSERT_EQ(table.rows, 10U);
    ASSERT_EQ(table.columns, 9U);
    // Row i is sample i for its viewer.
    const DirectionSamples of_second =
        sample_material(device(), read_material(material), second, 10, 0, Sequence::Sobol);
    for (std::size_t i = 0; i < 10; ++i)
        EXPECT_EQ(table.at(i, 5), i < 5 ? 1.0F : static_cast<float>(second[2]));
    for (std::size_t i = 5; i < 10; ++i) {
        EXPECT_EQ(table.at(i, 0), of_second.wi_x[i]);
        EXPECT_EQ(table.at(i, 6), of_second.pdf[i]);
    }
    write_file(viewers, "wo_x,wo_y,wo_z\n0,0,1\n0,0.6,-0.8\n");
    const Outcome below =
        run_program({"sample", material, "--wo", viewers, "-n", "5", "-o", folder / "b.npy"});
    EXPECT_EQ(below.status, 1);
    EXPECT_NE(below.err.find("v.csv: line 3: wo is not above the horizon"), std::string::npos)
        << below.err;
    write_file(viewers, "wo_x,wo_y\n0,0\n");
    EXPECT_EQ(run_program({"sample", material, "--wo", viewers, "-n", "5", "-o", folder / "b.npy"})
                  .status,
              1);
    write_file(viewers, "wo_x,wo_y,wo_z\n0,0,1\n0,0,1\n");
    EXPECT_EQ(
        run_program({"sample", material, "--wo", viewers, "-n", "60000000", "-o", folder / "b.npy"})
            .status,
        2);
    EXPECT_FALSE(std::filesystem::exists(folder / "b.npy"));
}

TEST(SampleCommand, refuses_bad_command_lines) {
    const TemporaryFolder folder;
    const std::string material = folder / "m.json", out = folder / "s.csv";
    write_file(material, mixed_material);
    const std::vector<std::vector<std::string>> wrong = {
        {"sample", material, "-n", "10", "-o", out},
        {"sample", material, "--wo", "10,0", "-o", out},
        {"sample", material, "--wo", "10", "-n", "10", "-o", out},
        {"sample", material, "--wo", "10,x", "-n", "10", "-o", out},
        {"sample", material, "--wo", "10,0,0", "-n", "10", "-o", out},
        {"sample", material, "--wo", "90,0", "-n", "10", "-o", out},
        {"sample", material, "--wo", "-1,0", "-n", "10", "-o", out},
        {"sample", material, "--wo", "nan,0", "-n", "10", "-o", out},
        {"sample", material, "--wo", "1,inf", "-n", "10", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "0", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "-5", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "4294967296", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "1.5", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "10", "--seed", "-1", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "10", "--sequence", "halton", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "10", "-o", folder / "s.txt"},
        {"sample", material, "--wo", "10,0", "-n", "10"},
        {"pdf", material, "-o", out},
        {"pdf", material, material, "-o", folder / "p.exr", "--no-such-option"},
    };
    for (const std::vector<std::string>& arguments : wrong) {
        const Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.status, 2) << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_NE(outcome.err, "");
    }
    const std::vector<std::vector<std::string>> bad = {
        {"sample", folder / "none.json", "--wo", "10,0", "-n", "10", "-o", out},
        {"sample", material, "--wo", "10,0", "-n", "10", "-o", folder / "none/s.csv"},
        {"pdf", material, folder / "none.csv", "-o", out},
        {"pdf", material, material, "-o", out},
    };
    for (const std::vector<std::string>& arguments : bad) {
        const Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.status, 1) << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_NE(outcome.err, "");
    }
    EXPECT_FALSE(std::filesystem::exists(out));
}

} // namespace brdfit::test

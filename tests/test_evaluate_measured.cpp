// Measured files at any directions, and materials and files tabulated for renderers.

#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/measured.hpp"
#include "host/evaluate/rgl.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/evaluate/tabulate.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/write.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/measured.hpp"
#include "tests/support/pairs.hpp"
#include "tests/support/rgl.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

using test::complaint;
using test::run_program;
using test::write_file;

const std::string paint = R"({"brdfit": 1, "channels": ["R", "G", "B"],
    "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
    "lobes": [{"model": "ggx", "ks": [0.5, 0.4, 0.3], "f0": 0.05, "a": 0.2}]})";
const std::string brushed = test::changed(paint, "\"a\": 0.2", "\"ax\": 0.2, \"ay\": 0.35");

class EvaluateMeasured : public test::Measured {
  protected:
    const std::string path = folder / "file";

    Material material_of(const std::string& text) {
        write_file(folder / "m.json", text);
        return read_material(folder / "m.json");
    }
    /// Relative errors of values against others, sorted.
    static std::vector<double> errors(const std::vector<float>& a, const std::vector<float>& b) {
        EXPECT_EQ(a.size(), b.size());
        std::vector<double> made;
        for (std::size_t k = 0; k < a.size(); ++k)
            made.push_back(std::abs(a[k] - b[k]) / std::max(std::abs(b[k]), 1e-3F));
        std::sort(made.begin(), made.end());
        return made;
    }
    static double at(const std::vector<double>& sorted, double share) {
        return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    }
};

/// Pairs away from the horizon.
std::vector<test::Pair> pairs_above(std::size_t count, double least) {
    test::Random random(11);
    std::vector<test::Pair> pairs;
    while (pairs.size() < count) {
        pairs.push_back(test::random_pair(random));
        if (pairs.back().wi[2] < least || pairs.back().wo[2] < least)
            pairs.pop_back();
    }
    return pairs;
}

TEST_F(EvaluateMeasured, merl_is_linear_between_bins) {
    const Material material = material_of(paint);
    write_samples(synthesise_merl(test::device(), material, 0, 1, "m.json"), folder / "m.binary");
    const MeasuredBrdf merl(folder / "m.binary");
    EXPECT_TRUE(merl.isotropic());
    EXPECT_EQ(merl.scattered(), nullptr);
    // At bin centres the bins' values.
    const Samples& samples = merl.samples();
    const std::vector<float> same = merl.evaluate(test::device(), *samples.directions);
    std::size_t off = 0;
    for (std::size_t k = 0; k < samples.count(); ++k)
        if (samples.valid[k] != 0)
            off += std::abs(same[k] - samples.values[k]) > 1e-3F * samples.values[k];
    EXPECT_LT(off, samples.count() / 1000);
    // Between them nearly the material's.
    const Directions directions = test::directions_of(pairs_above(20000, 0.2));
    const std::vector<double> error = errors(merl.evaluate(test::device(), directions),
                                             evaluate(test::device(), material, directions));
    EXPECT_LT(at(error, 0.5), 2e-4);
    EXPECT_LT(at(error, 0.95), 0.01);
}

TEST_F(EvaluateMeasured, utia_is_linear_between_nodes) {
    // A function that is linear in every cell: of theta_i, theta_o and of folded azimuths.
    const auto f = [](const Vector& w) {
        const double theta = std::min(std::atan2(std::hypot(w[0], w[1]), w[2]), 75 * degree);
        return 1 + theta + theta * std::abs(std::atan2(w[1], w[0]));
    };
    std::vector<double> table;
    for (int channel = 0; channel < 3; ++channel)
        for (std::size_t i = 0; i < utia::directions; ++i)
            for (std::size_t o = 0; o < utia::directions; ++o)
                table.push_back((channel + 1) * f(utia::node_direction(i)) *
                                f(utia::node_direction(o)));
    write_file(path, {reinterpret_cast<const char*>(table.data()), table.size() * sizeof(double)});
    const MeasuredBrdf utia(path);
    const std::vector<test::Pair> pairs = pairs_above(3000, 0.01);
    const std::vector<float> values = utia.evaluate(test::device(), test::directions_of(pairs));
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        // In the cell around the normal azimuths are linear too, from node to node.
        const double expected = f(pairs[k].wi) * f(pairs[k].wo);
        ASSERT_NEAR(values[k], expected, 1e-4 * expected) << k;
        ASSERT_NEAR(values[2 * pairs.size() + k], 3 * expected, 3e-4 * expected) << k;
    }
}

TEST_F(EvaluateMeasured, scattered_samples_have_their_values) {
    for (const std::string& text : {paint, brushed}) {
        const Material material = material_of(text);
        const bool isotropic = material.isotropic();
        const Samples samples =
            synthesise(test::device(), material, random_directions(20000, isotropic, 1), 0, 1);
        write_samples(samples, folder / "s.csv");
        const MeasuredBrdf scattered(folder / "s.csv");
        ASSERT_NE(scattered.scattered(), nullptr);
        // A sample of a smooth material is what the others say, nearly as well as between them.
        const RelativeError left_out = scattered.scattered()->leave_one_out();
        EXPECT_GT(left_out.median, 1e-4);
        EXPECT_LT(left_out.median, isotropic ? 0.02 : 0.06);
        EXPECT_GT(left_out.high, left_out.median);
        EXPECT_EQ(scattered.isotropic(), isotropic);
        const std::vector<double> own =
            errors(scattered.evaluate(test::device(), *samples.directions), samples.values);
        EXPECT_LT(at(own, 0.999), 1e-3);
        // Elsewhere near the material, turned and with wi and wo exchanged too.
        const std::vector<test::Pair> pairs = pairs_above(5000, 0.2);
        std::vector<test::Pair> turned;
        for (const test::Pair& pair : pairs)
            turned.push_back({pair.wo, pair.wi});
        const std::vector<float> values =
            scattered.evaluate(test::device(), test::directions_of(pairs));
        const std::vector<double> error =
            errors(values, evaluate(test::device(), material, test::directions_of(pairs)));
        EXPECT_LT(at(error, 0.5), isotropic ? 0.01 : 0.03);
        EXPECT_LT(at(error, 0.95), isotropic ? 0.1 : 0.25);
        EXPECT_LT(
            at(errors(scattered.evaluate(test::device(), test::directions_of(turned)), values),
               0.999),
            1e-3);
    }
}

TEST_F(EvaluateMeasured, files_without_valid_samples_are_refused) {
    write_file(path, test::merl_header(90, 90, 180));
    std::filesystem::resize_file(path, 12 + 3 * merl::bins * sizeof(double));
    EXPECT_NO_THROW(MeasuredBrdf{path});
    const std::vector<double> values(3 * merl::bins, -1);
    write_file(path, test::merl_header(90, 90, 180) +
                         std::string(reinterpret_cast<const char*>(values.data()),
                                     values.size() * sizeof(double)));
    test::expect_complaint(complaint([&] { MeasuredBrdf{path}; }), path, "no valid samples");
}

TEST_F(EvaluateMeasured, materials_are_tabulated_to_the_error_that_is_said) {
    for (const std::string& text : {paint, brushed}) {
        const Material material = material_of(text);
        const bool isotropic = material.isotropic();
        const RglChannels channels = rgl_channels(material.channels, false, "m");
        const BrdfFunction brdf = [&](const Directions& directions) {
            return evaluate(test::device(), material, directions);
        };
        const std::optional<RglSize> size =
            isotropic ? std::nullopt : std::optional(RglSize{17, 24, 48});
        const Tabulated made = tabulate(test::device(), brdf, channels, isotropic, size,
                                        {{0.0025, 0.025}, std::size_t{16} << 20});
        EXPECT_EQ(made.tables.isotropic(), isotropic);
        EXPECT_EQ(made.tables.reduction(), 1) << "renderers want the whole circle";
        EXPECT_LT(made.error.median, isotropic ? 0.0025 : 0.01);
        EXPECT_LT(made.error.high, isotropic ? 0.025 : 0.04);
        // Read again it is the material.
        rgl::write(made.tables, folder / "t.bsdf");
        const MeasuredBrdf again(folder / "t.bsdf");
        const Directions directions = test::directions_of(pairs_above(20000, 0.2));
        const std::vector<double> error =
            errors(again.evaluate(test::device(), directions), brdf(directions));
        EXPECT_LT(at(error, 0.5), 2 * made.error.median);
        EXPECT_LT(at(error, 0.95), 2 * made.error.high);
        // The sampling density makes weights even: f cos over it is the albedo everywhere.
        const RglTables& tables = made.tables;
        for (std::size_t slice = 0; slice + 2 < tables.slices(); slice += 3) {
            const std::size_t nodes = tables.table.count();
            for (std::size_t node = 0; node < nodes; ++node) {
                const float density = tables.luminance.values[slice * nodes + node];
                const float value = tables.table.values[(slice * 3 + 1) * nodes + node];
                ASSERT_GE(density, 0);
                ASSERT_FALSE(value == 0 && density > 0) << "below the horizon";
                ASSERT_FALSE(value > 0 && density == 0 && node % tables.table.width > 0);
            }
        }
    }
}

TEST_F(EvaluateMeasured, channels_become_rgb_or_wavelengths) {
    using Names = std::vector<std::string>;
    const RglChannels rgb = rgl_channels({"R", "G", "B"}, false, "f");
    EXPECT_EQ(rgb.names, (Names{"R", "G", "B"}));
    EXPECT_TRUE(rgb.wavelengths.empty());
    const RglChannels spectrum = rgl_channels({"R", "G", "B"}, true, "f");
    EXPECT_EQ(spectrum.wavelengths, (std::vector<float>{465, 545, 620}));
    EXPECT_EQ(spectrum.source, (std::vector<std::size_t>{2, 1, 0}));
    const RglChannels one = rgl_channels({"channel_1"}, false, "f");
    EXPECT_EQ(one.source, (std::vector<std::size_t>{0, 0, 0}));
    const RglChannels lines = rgl_channels({"500", "400.5"}, false, "f");
    EXPECT_EQ(lines.wavelengths, (std::vector<float>{400.5F, 500}));
    EXPECT_EQ(lines.source, (std::vector<std::size_t>{1, 0}));
    test::expect_complaint(complaint([] {
                               rgl_channels({"a", "b"}, false, "f");
                           }),
                           "f", "2 channels; an RGL file has R, G and B");
    EXPECT_NE(complaint([] { rgl_channels({"400", "400"}, true, "f"); }), "");
}

TEST_F(EvaluateMeasured, rgl_files_are_converted_as_they_are) {
    const std::string out = folder / "out.bsdf";
    write_file(path, test::tensor_bytes(test::rgl_fields(4, pi)));
    const test::Outcome outcome = run_program({"convert", path, out});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("the tables of"), std::string::npos);
    auto before = test::rgl_fields(4, pi), after = test::read_fields(test::read_file(out));
    for (const char* name : {"phi_i", "theta_i", "ndf", "sigma", "vndf", "luminance", "rgb"})
        EXPECT_EQ(test::field_of(after, name).values, test::field_of(before, name).values) << name;
    EXPECT_EQ(run_program({"convert", path, out, "--spectral"}).status, 0);
    after = test::read_fields(test::read_file(out));
    EXPECT_EQ(test::field_of(after, "wavelengths").values, (std::vector<float>{465, 545, 620}));
    EXPECT_EQ(test::field_of(after, "spectra").shape, (std::vector<std::uint64_t>{4, 4, 3, 5, 5}));
    EXPECT_EQ(test::field_of(after, "spectra").values[0],
              test::field_of(before, "rgb").values[50]); // blue first
}

TEST_F(EvaluateMeasured, convert_and_eval_say_what_is_wrong) {
    const std::string material = folder / "m.json", out = folder / "out.bsdf";
    write_file(material, paint);
    write_file(folder / "b.json", brushed);
    const auto status = [](const std::vector<std::string>& arguments) {
        const test::Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.err.find("terminate"), std::string::npos);
        return outcome.status;
    };
    EXPECT_EQ(status({"convert", material, out, "--size", "8,16"}), 0);
    EXPECT_EQ(test::read_fields(test::read_file(out))[1].shape[0], 1U);
    EXPECT_EQ(status({"convert", folder / "b.json", out, "--size", "3,8,16", "--spectral"}), 0);
    EXPECT_EQ(status({"convert", folder / "b.json", out, "--size", "8,16"}), 2);
    EXPECT_EQ(status({"convert", material, out, "--size", "3,8,16"}), 2);
    EXPECT_EQ(status({"convert", material, out, "--size", "1,16"}), 2);
    EXPECT_EQ(status({"convert", material, out, "--size", "8,99999"}), 2);
    EXPECT_EQ(status({"convert", material, out, "--isotropic"}), 2);
    EXPECT_EQ(status({"convert", material, folder / "out.csv"}), 1) << "a material is no samples";
    EXPECT_EQ(status({"convert", path, out}), 1) << "no such file";
    write_file(path, test::csv_example);
    EXPECT_EQ(status({"convert", path, out}), 1) << "two channels";
    EXPECT_EQ(status({"convert", path, folder / "out.csv", "--spectral"}), 2);
    write_file(folder / "d.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0.6,0,0.8\n");
    EXPECT_EQ(status({"eval", path, folder / "d.csv", "-o", folder / "v.csv"}), 0);
    EXPECT_NE(test::read_file(folder / "v.csv").find("wo_z,R,G\n0,0,1"), std::string::npos);
    write_file(path, "nothing");
    EXPECT_EQ(status({"eval", path, folder / "d.csv", "-o", folder / "v.csv"}), 1);
}

TEST_F(EvaluateMeasured, every_measured_file_is_converted_for_renderers) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* file :
         {"cornell/garnet_red.brdf", "cornell/krylon_blue_RGB.astm", "rgl/chm_mint_rgb.bsdf",
          "ua-loft/processed__zemax__IMX455.bsdf", "ua-loft/processed__fred__AnoBlackEC1onAlum.txt",
          "alta/retro-3M-jaune.dat"}) {
        const bool anisotropic = std::string(file).find("IMX") != std::string::npos;
        const test::Outcome outcome =
            run_program({"convert", (test::data_folder() / file).string(), folder / "out.bsdf",
                         "--size", anisotropic ? "5,8,16" : "8,32"});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        test::expect_whole(read_samples(folder / "out.bsdf"), file);
    }
}

/// What one of the scripts beside these tests says of a file; they need Mitsuba.
test::Outcome checked_by(const std::string& script, const std::string& file) {
    const char* const python = std::getenv("BRDFIT_PYTHON");
    return test::run_command({python != nullptr && *python != '\0' ? python : "python3",
                              fmt::format("{}/tests/{}", BRDFIT_SOURCES, script), BRDFIT_PROGRAM,
                              file});
}

TEST_F(EvaluateMeasured, mitsuba_makes_the_same_picture_of_a_file_and_of_what_is_written) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    const test::Outcome outcome =
        checked_by("check_sphere.py", (test::data_folder() / "rgl/chm_orange_rgb.bsdf").string());
    if (outcome.status != 0 && outcome.status != 1)
        GTEST_SKIP() << "python3 (or what BRDFIT_PYTHON names) has no mitsuba";
    EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
}

TEST_F(EvaluateMeasured, mitsuba_renders_what_is_written) {
    write_file(folder / "m.json", paint);
    const test::Outcome outcome = checked_by("check_mitsuba.py", folder / "m.json");
    if (outcome.status != 0 && outcome.status != 1)
        GTEST_SKIP() << "python3 (or what BRDFIT_PYTHON names) has no mitsuba";
    EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
}

} // namespace

} // namespace brdfit

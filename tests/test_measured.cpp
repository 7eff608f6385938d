// Measured files in every format that is no grid, lists of directions, and the commands info and
// convert.

#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/files/directions.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "tests/support/measured.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace brdfit {

namespace {

using test::distance;
using test::Measured;
using test::npy_file;
using test::npy_values;
using test::read_file;
using test::run_program;
using test::write_file;

const char* const csv_example = "# a comment\n"
                                "theta_i,phi_i,theta_o,phi_o,R,G,B\n"
                                "0.5,0,0.25,3,0.1,0.2,0.3\n"
                                "0.5,0,0.75,-1.5,-0.01,2e-2,3E+1\n";
const char* const astm_example = "LAB_NAME A laboratory\r\n"
                                 "\r\n"
                                 "NUM_POINTS 2\r\n"
                                 "VARS theta_i,phi_i,theta_s,phi_s,R,G\r\n"
                                 "\r\n"
                                 "0.872665,0.000000,0.573513,0.100000,0.011364,-0.000779\r\n"
                                 "0.698132,0.000000,0.427512,-0.261799,0.012770,0.000718\r\n";
const char* const cornell_example = "# A sample\r\n\r\n# num wls\r\n4\r\n\r\n# wls\r\n"
                                    "400 450 500\r\n550\r\n\r\n# theta i, phi i, ...\r\n\r\n"
                                    "0.5 0.0 0.25 0.0 0.1 0.2 0.3 0.4\r\n"
                                    "0.6 0.0 0.35 1.0 0.5 0.6 0.7 -0.8\r\n";

TEST_F(Measured, csv_is_read) {
    const Samples samples = read(csv_example);
    EXPECT_EQ(samples.format, "scattered CSV");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"R", "G", "B"}));
    ASSERT_EQ(samples.count(), 2U);
    EXPECT_EQ(samples.values, (std::vector<float>{0.1F, -0.01F, 0.2F, 2e-2F, 0.3F, 30}));
    EXPECT_TRUE(samples.weights.empty());
    EXPECT_EQ(samples.valid, (std::vector<std::uint8_t>{1, 1})) << "negative values are noise";
    EXPECT_LT(distance(samples.directions->wi(1), direction(0.5, 0)), 1e-7);
    EXPECT_LT(distance(samples.directions->wo(1), direction(0.75, -1.5)), 1e-7);
    EXPECT_EQ(samples.sha256.size(), 64U);
}

TEST_F(Measured, csv_takes_what_programs_write) {
    const Samples plain = read("theta_i,phi_i,theta_o,phi_o,x\n0.5,0,0.25,3,7\n0.5,0,1,2,8\n");
    for (const char* text : {
             "\xEF\xBB\xBFtheta_i,phi_i,theta_o,phi_o,x\n0.5,0,0.25,3,7\n0.5,0,1,2,8\n",
             "theta_i,phi_i,theta_o,phi_o,x\r\n0.5,0,0.25,3,7\r\n0.5,0,1,2,8",
             "\n# note\n# note\ntheta_i, phi_i ,theta_o,\tphi_o,x\n\n "
             "0.5,0,0.25,3,+7\n0.5,0,1,2,8\n\n",
             "x,phi_o,theta_o,phi_i,theta_i\n7,3,0.25,0,0.5\n8e0,2,1,0,.5\n",
         }) {
        const Samples samples = read(text);
        EXPECT_EQ(samples.channels, plain.channels) << text;
        EXPECT_EQ(samples.values, plain.values) << text;
        EXPECT_EQ(samples.directions->data(), plain.directions->data()) << text;
    }
}

TEST_F(Measured, csv_may_have_weights) {
    const Samples samples =
        read("theta_i,phi_i,weight,theta_o,phi_o,x\n0.5,0,2,0.25,3,7\n0.5,0,0,1,2,8\n");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"x"}));
    EXPECT_EQ(samples.values, (std::vector<float>{7, 8}));
    EXPECT_EQ(samples.weights, (std::vector<float>{2, 0}));
}

TEST_F(Measured, equal_azimuths_are_isotropic) {
    const std::string head = "theta_i,phi_i,theta_o,phi_o,x\n";
    const std::string same = head + "0.5,0.3,0.25,3,7\n0.6,0.3,1,2,8\n";
    const std::string different = head + "0.5,0.3,0.25,3,7\n0.6,0.4,1,2,8\n";
    EXPECT_TRUE(read(same).isotropic);
    EXPECT_TRUE(read(head + "0.5,0,0.25,3,7\n0.6,-0,1,2,8\n").isotropic);
    EXPECT_FALSE(read(different).isotropic);
    EXPECT_FALSE(read(same, false).isotropic);
    EXPECT_TRUE(read(different, true).isotropic);
}

TEST_F(Measured, angle_rounded_above_half_pi_is_half_pi) {
    const Samples samples = read("theta_i,phi_i,theta_o,phi_o,x\n1.570797,0,1.5708,3,7\n");
    EXPECT_NEAR(samples.directions->wi(0)[2], 0, 1e-15);
    EXPECT_GE(samples.directions->wo(0)[2], 0);
}

TEST_F(Measured, csv_written_keeps_isotropy) {
    const std::string head = "theta_i,phi_i,theta_o,phi_o,x\n";
    const Samples isotropic = read(head + "0.5,0.4,0.25,3,7\n0.6,0.7,1,-3,8\n", true);
    write_samples(isotropic, folder / "i.csv");
    const Samples again = read_samples(folder / "i.csv");
    EXPECT_TRUE(again.isotropic);
    EXPECT_LT(distance(again.directions->wi(1), direction(0.6, 0)), 2e-7);
    EXPECT_LT(distance(again.directions->wo(0), direction(0.25, 2.6)), 2e-7);
    EXPECT_LT(distance(again.directions->wo(1), direction(1, -3.7)), 2e-7);

    const Samples anisotropic = read(head + "0.5,0.4,0.25,3,7.1\n0.6,0.7,1,-3,-1e-7\n");
    write_samples(anisotropic, folder / "a.csv");
    const Samples same = read_samples(folder / "a.csv");
    EXPECT_FALSE(same.isotropic);
    EXPECT_EQ(same.values, anisotropic.values);
    EXPECT_EQ(same.channels, anisotropic.channels);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_LT(distance(same.directions->wi(k), anisotropic.directions->wi(k)), 2e-7);
        EXPECT_LT(distance(same.directions->wo(k), anisotropic.directions->wo(k)), 2e-7);
    }
}

TEST_F(Measured, csv_written_has_weights_where_they_differ) {
    Samples samples = read(csv_example);
    const auto header = [&] {
        write_samples(samples, folder / "a.csv");
        const std::string text = read_file(folder / "a.csv");
        return text.substr(0, text.find('\n'));
    };
    EXPECT_EQ(header(), "theta_i,phi_i,theta_o,phi_o,R,G,B");
    samples.weights = {1, 1};
    EXPECT_EQ(header(), "theta_i,phi_i,theta_o,phi_o,R,G,B");
    samples.weights = {1, 0.5};
    EXPECT_EQ(header(), "theta_i,phi_i,theta_o,phi_o,R,G,B,weight");
    EXPECT_EQ(read_samples(folder / "a.csv").weights, samples.weights);
    samples.valid[1] = 0;
    EXPECT_EQ(header(), "theta_i,phi_i,theta_o,phi_o,R,G,B");
    EXPECT_EQ(read_samples(folder / "a.csv").count(), 1U);
}

TEST_F(Measured, samples_are_written_as_npy) {
    Samples samples = read("theta_i,phi_i,theta_o,phi_o,x,y,weight\n"
                           "0.5,0.1,0.25,3,7,8,0.5\n0.6,0.2,1,2,9,10,2\n0.7,0.3,1,2,11,12,3\n");
    samples.valid[1] = 0;
    write_samples(samples, folder / "a.npy");
    const std::vector<float> values = npy_values(folder / "a.npy", 2, 9);
    const Vector wi = direction(0.7, 0.3), wo = direction(1, 2);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_FLOAT_EQ(values[9 + i], static_cast<float>(wi[i]));
        EXPECT_FLOAT_EQ(values[12 + i], static_cast<float>(wo[i]));
    }
    EXPECT_EQ(values[6], 7);
    EXPECT_EQ(values[8], 0.5);
    EXPECT_EQ(values[15], 11);
    EXPECT_EQ(values[16], 12);
    EXPECT_EQ(values[17], 3);
}

TEST_F(Measured, npy_written_is_read_back) {
    for (const bool isotropic : {true, false}) {
        Samples samples = read("theta_i,phi_i,theta_o,phi_o,R,G,B,weight\n"
                               "0.5,0.1,0.25,3,7,8,9,0.5\n0.7,0.3,1,2,-11,12,1,3\n");
        samples.isotropic = isotropic;
        write_samples(samples, folder / "a.npy");
        const Samples back = read_samples(folder / "a.npy");
        EXPECT_EQ(back.isotropic, isotropic);
        EXPECT_EQ(back.channels, samples.channels);
        EXPECT_EQ(back.values, samples.values);
        EXPECT_EQ(back.weights, samples.weights);
        EXPECT_EQ(back.valid, samples.valid);
        for (std::size_t k = 0; k < 2; ++k) {
            EXPECT_NEAR(back.directions->plane(Directions::WiZ)[k],
                        samples.directions->plane(Directions::WiZ)[k], 1e-6);
            EXPECT_NEAR(back.directions->plane(Directions::HZ)[k],
                        samples.directions->plane(Directions::HZ)[k], 1e-6);
            EXPECT_NEAR(back.directions->plane(Directions::C)[k],
                        samples.directions->plane(Directions::C)[k], 1e-6);
        }
    }
}

TEST_F(Measured, what_is_no_measurement_is_named) {
    const std::pair<std::string, std::string> cases[] = {
        {"\x76\x2f\x31\x01 and more", "OpenEXR"},
        {"{\"brdfit\": 1}", "a JSON file, such as a material"},
        {"\x1f\x8b\x08 and more", "gzip"},
        {"\n<!DOCTYPE html>\n<html>", "HTML"},
        {"<HTML><head>", "HTML"},
    };
    for (const auto& [bytes, name] : cases) {
        write_file(folder / "file", bytes);
        const std::string message = test::complaint([&] { read_samples(folder / "file"); });
        EXPECT_NE(message.find(name), std::string::npos) << message;
    }
}

TEST_F(Measured, astm_is_read) {
    const Samples samples = read(astm_example);
    EXPECT_EQ(samples.format, "ASTM E1392 text");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"R", "G"}));
    EXPECT_EQ(samples.values, (std::vector<float>{0.011364F, 0.01277F, -0.000779F, 0.000718F}));
    EXPECT_EQ(samples.valid_count(), 2U);
    EXPECT_TRUE(samples.isotropic);
    EXPECT_LT(distance(samples.directions->wi(0), direction(0.872665, 0)), 1e-7);
    EXPECT_LT(distance(samples.directions->wo(1), direction(0.427512, -0.261799)), 1e-7);
}

TEST_F(Measured, cornell_is_read) {
    const Samples samples = read(cornell_example);
    EXPECT_EQ(samples.format, "Cornell spectral text");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"400", "450", "500", "550"}));
    ASSERT_EQ(samples.count(), 2U);
    EXPECT_EQ(samples.channel(3)[1], -0.8F);
    EXPECT_EQ(samples.channel(1)[0], 0.2F);
    EXPECT_EQ(samples.valid_count(), 2U);
    EXPECT_TRUE(samples.isotropic);
    EXPECT_LT(distance(samples.directions->wo(1), direction(0.35, 1)), 1e-7);
}

TEST_F(Measured, content_decides_not_the_name) {
    write_file(folder / "a.binary", csv_example);
    write_file(folder / "a.csv", cornell_example);
    write_file(folder / "a", astm_example);
    EXPECT_EQ(read_samples(folder / "a.binary").format, "scattered CSV");
    EXPECT_EQ(read_samples(folder / "a.csv").format, "Cornell spectral text");
    EXPECT_EQ(read_samples(folder / "a").format, "ASTM E1392 text");
}

TEST_F(Measured, directions_are_read_from_csv_and_npy) {
    // A vector 5e-4 too long is normalised; below the horizon is kept.
    const std::vector<double> rows{0, 0, 1, 0.6, 0, 0.8, 0, -0.6003, -0.8004, 1, 0, 0};
    std::string csv = "# made by hand\nwi_x,wi_y,wi_z,wo_x,wo_y,wo_z\r\n";
    for (std::size_t i = 0; i < rows.size(); ++i)
        csv += fmt::format("{}{}", rows[i], i % 6 == 5 ? "\r\n" : ",");
    const std::string header32 = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 6), }   \n";
    const std::string header64 = "{\"shape\":(2,6,),\"fortran_order\":False,\"descr\":\"<f8\"}";
    const std::vector<float> rows32(rows.begin(), rows.end());
    for (const std::string& bytes :
         {csv, npy_file(1, header32, rows32), npy_file(1, header64, rows),
          npy_file(2, header64, rows), npy_file(3, header32, rows32)}) {
        const Directions got = directions(bytes);
        ASSERT_EQ(got.count(), 2U);
        EXPECT_LT(distance(got.wi(0), {0, 0, 1}), 1e-7);
        EXPECT_LT(distance(got.wo(0), {0.6, 0, 0.8}), 1e-7);
        EXPECT_LT(distance(got.wi(1), {0, -0.6, -0.8}), 1e-7);
        EXPECT_LT(distance(got.wo(1), {1, 0, 0}), 1e-7);
        EXPECT_NEAR(got.plane(Directions::C)[0], std::sqrt(0.9), 1e-7);
        EXPECT_TRUE(got.above_horizon(0));
        EXPECT_FALSE(got.above_horizon(1));
    }
}

TEST_F(Measured, columns_are_written) {
    const std::vector<std::vector<float>> columns{{0.1F, 1e-20F, 3}, {-1, 1.0F / 3, 2e10F}};
    write_columns(folder / "a.csv", {"x", "y"}, columns, {"line 1"});
    EXPECT_EQ(read_file(folder / "a.csv"),
              "# line 1\nx,y\n0.1,-1\n1e-20,0.33333334\n3,20000000000\n");
    write_columns(folder / "a.npy", {"x", "y"}, columns);
    EXPECT_EQ(npy_values(folder / "a.npy", 3, 2),
              (std::vector<float>{0.1F, -1, 1e-20F, 1.0F / 3, 3, 2e10F}));
    EXPECT_THROW(write_columns(folder / "a.binary", {"x", "y"}, columns), UsageError);
    EXPECT_THROW(write_columns(folder / "a", {"x", "y"}, columns), UsageError);
}

TEST_F(Measured, npy_header_is_aligned_for_any_shape) {
    for (std::size_t rows : {1U, 9U, 10U, 99U, 100U, 12345U, 1234567U}) {
        write_columns(folder / "a.npy", {"x"}, {std::vector<float>(rows, 2.0F)});
        EXPECT_EQ(npy_values(folder / "a.npy", rows, 1).back(), 2.0F);
    }
}

TEST_F(Measured, info_describes_a_file) {
    write_file(folder / "a.csv", csv_example);
    const test::Outcome text = run_program({"info", folder / "a.csv"});
    EXPECT_EQ(text.status, 0) << text.err;
    EXPECT_EQ(text.out, (folder / "a.csv") +
                            "\n"
                            "  format         scattered CSV\n"
                            "  samples        2\n"
                            "  valid          2\n"
                            "  channels       3: R, G, B\n"
                            "  range          -0.01 to 30 1/sr\n"
                            "  below horizon  0.0 %\n"
                            "  isotropic      yes\n"
                            "  sha256         " +
                            sha256(csv_example) + "\n");
    EXPECT_EQ(text.err, "");
    const test::Outcome json = run_program({"info", "--json", "--anisotropic", folder / "a.csv"});
    EXPECT_EQ(json.status, 0);
    const auto object = nlohmann::json::parse(json.out);
    EXPECT_EQ(object["file"], folder / "a.csv");
    EXPECT_EQ(object["format"], "scattered CSV");
    EXPECT_EQ(object["samples"], 2);
    EXPECT_EQ(object["valid"], 2);
    EXPECT_EQ(object["channels"], (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_FLOAT_EQ(object["range"][0].get<float>(), -0.01F);
    EXPECT_EQ(object["range"][1], 30);
    EXPECT_EQ(object["below_horizon_percent"], 0);
    EXPECT_EQ(object["isotropic"], false);
    EXPECT_EQ(object["sha256"], sha256(csv_example));
}

TEST_F(Measured, info_goes_on_after_a_bad_file) {
    write_file(folder / "a.csv", csv_example);
    write_file(folder / "b.astm", astm_example);
    const std::string missing = folder / "missing";
    const test::Outcome text = run_program({"info", folder / "a.csv", missing, folder / "b.astm"});
    EXPECT_EQ(text.status, 1);
    EXPECT_NE(text.out.find("scattered CSV"), std::string::npos);
    EXPECT_NE(text.out.find("ASTM E1392 text"), std::string::npos);
    EXPECT_NE(text.err.find(missing), std::string::npos);
    const test::Outcome json =
        run_program({"info", "--json", folder / "a.csv", missing, folder / "b.astm"});
    EXPECT_EQ(json.status, 1);
    const auto array = nlohmann::json::parse(json.out);
    ASSERT_EQ(array.size(), 2U);
    EXPECT_EQ(array[1]["format"], "ASTM E1392 text");
}

TEST_F(Measured, convert_writes_where_from_and_what_with) {
    write_file(folder / "a.brdf", cornell_example);
    const test::Outcome outcome = run_program({"convert", folder / "a.brdf", folder / "a.csv"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::string text = read_file(folder / "a.csv");
    EXPECT_EQ(text.find("# converted from Cornell spectral text by brdfit "), 0U) << text;
    EXPECT_NE(text.find("\n# source: a.brdf\n# sha256: " + sha256(cornell_example) +
                        "\ntheta_i,phi_i,theta_o,phi_o,400,450,500,550\n"),
              std::string::npos)
        << text;
    const Samples a = read_samples(folder / "a.brdf"), b = read_samples(folder / "a.csv");
    EXPECT_EQ(a.values, b.values);
    EXPECT_EQ(a.channels, b.channels);
    EXPECT_EQ(a.isotropic, b.isotropic);
    EXPECT_EQ(run_program({"convert", folder / "a.csv", folder / "a.npy"}).status, 0);
    npy_values(folder / "a.npy", 2, 6 + 4 + 1);
}

TEST_F(Measured, help_ends_with_an_example) {
    for (const char* command : {"info", "convert"}) {
        const test::Outcome outcome = run_program({command, "--help"});
        EXPECT_EQ(outcome.status, 0);
        EXPECT_NE(outcome.out.find(fmt::format("Example:\n  brdfit {} ", command)),
                  std::string::npos);
    }
}

TEST_F(Measured, published_cornell_files_are_read) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(test::data_folder() / "cornell")) {
        const bool spectral = entry.path().extension() == ".brdf";
        const Samples samples = read_samples(entry.path().string());
        EXPECT_EQ(samples.format, spectral ? "Cornell spectral text" : "ASTM E1392 text");
        EXPECT_EQ(samples.count(), 1439U) << entry.path();
        EXPECT_EQ(samples.valid_count(), 1439U);
        EXPECT_EQ(samples.channels.size(), spectral ? 31U : 3U);
        EXPECT_EQ(samples.channels.back(), spectral ? "700" : "B");
        EXPECT_TRUE(samples.isotropic);
        std::size_t negative = 0;
        for (const float value : samples.values)
            negative += value < 0;
        EXPECT_EQ(negative > 0, !spectral);
        write_samples(samples, folder / "again.csv");
        EXPECT_EQ(read_samples(folder / "again.csv").values, samples.values);
        ++files;
    }
    EXPECT_EQ(files, 6);
}

} // namespace

} // namespace brdfit

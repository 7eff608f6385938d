// Zemax, FRED and ALTA text and UTIA's binary: what is read, and what broken ones say.

#include "host/evaluate/evaluate.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/read.hpp"
#include "host/measured/rows.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/measured.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

using test::alta_example;
using test::changed;
using test::complaint;
using test::fred_example;
using test::write_file;
using test::zemax_example;

class Formats : public test::Measured {
  protected:
    const std::string path = folder / "file";

    void refused(const std::string& bytes, const std::string& part) {
        write_file(path, bytes);
        test::expect_complaint(complaint([&] { read_samples(path); }), path, part);
    }
    /// Broken copies of a file are whole or refused by name.
    void expect_read_or_refused(const std::string& bytes) {
        write_file(path, bytes);
        Samples samples;
        const std::string message = complaint([&] { samples = read_samples(path); });
        if (message.empty())
            test::expect_whole(samples, bytes);
        else
            EXPECT_EQ(message.find(path + ": "), 0U) << message;
    }
};

Vector at(double theta, double phi) {
    return direction(theta * degree, phi * degree);
}

std::string ua_loft(const std::string& name) {
    return (test::data_folder() / "ua-loft" / name).string();
}

TEST_F(Formats, zemax_directions_are_about_the_specular_one) {
    const Samples samples = read(zemax_example);
    test::expect_whole(samples, "the example");
    EXPECT_EQ(samples.format, "Zemax BSDF text, asymmetric");
    EXPECT_FALSE(samples.isotropic);
    const Directions& pairs = *samples.directions;
    const auto expect_pair = [&](std::size_t k, const Vector& wi, const Vector& wo, float value) {
        EXPECT_LT(test::distance(pairs.wi(k), wi), 1e-6) << k;
        EXPECT_LT(test::distance(pairs.wo(k), wo), 1e-6) << k;
        EXPECT_EQ(samples.values[k], value) << k;
    };
    // Zeros at a row's end were not measured.
    ASSERT_EQ(samples.count(), 29U);
    EXPECT_EQ(samples.left_out, 7U);
    EXPECT_EQ(samples.valid_count(), 29U);
    expect_pair(0, at(15, 0), at(15, 180), 1);    // the specular direction
    expect_pair(1, at(15, 0), at(15, 0), 0.5F);   // 30 degrees towards the normal: to the light
    expect_pair(2, at(15, 0), at(65, 0), 0.25F);  // and beyond it
    expect_pair(6, at(15, 0), at(45, 180), 0.7F); // away from it
    expect_pair(7, at(30, 0), at(30, 180), 2);    // the second incidence
    expect_pair(14, at(15, 90), at(15, 270), 3);  // the second rotation
    // To the side, 30 degrees from the specular direction.
    EXPECT_NEAR(pairs.wo(4)[1], 0.5, 1e-6);
    EXPECT_NEAR(test::dot(pairs.wo(4), at(15, 180)), std::cos(30 * degree), 1e-6);
}

TEST_F(Formats, zemax_is_isotropic_without_rotations) {
    const std::string one = changed(changed(zemax_example, "Rotation\t2\n0\t90", "Rotation\t1\n0"),
                                    "ASymmetrical", "PlaneSymmetrical");
    const Samples samples = read(changed(one, one.substr(one.find("3 0.5")), "DataEnd\n"));
    EXPECT_TRUE(samples.isotropic);
    EXPECT_EQ(samples.format, "Zemax BSDF text, plane-symmetric");
    EXPECT_EQ(samples.count() + samples.left_out, 18U);
}

TEST_F(Formats, zemax_has_three_channels) {
    const std::size_t data = zemax_example.find("Monochrome\nDataBegin");
    std::string xyz = changed(zemax_example.substr(0, data), "Monochrome", "XYZ");
    for (const char* name : {"X", "Y", "Z"})
        xyz += changed(zemax_example.substr(data), "Monochrome", std::string("Tristimulus") + name);
    const Samples samples = read(xyz);
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"X", "Y", "Z"}));
    EXPECT_EQ(samples.channel(2)[14], 3);
    refused(xyz.substr(0, xyz.find("TristimulusZ")), "the file ends after 2 of 3 channels");
}

// The files' authors integrate f alone over the azimuths they list, without the cosine.
TEST_F(Formats, zemax_blocks_integrate_to_their_scatter) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const std::string name :
         {"validation__zemax__ValidationTest_of_TIS_via_BrownVinyl.bsdf",
          "processed__zemax__AnoBlackEC1onAlum.bsdf", "processed__zemax__AnoBlackNiTEonSteel.bsdf",
          "processed__zemax__IMX455.bsdf"}) {
        const std::string bytes = test::read_file(ua_loft(name));
        std::vector<double> scatter; // as the file has it
        for (std::size_t at = bytes.find("\nTIS\t"); at != bytes.npos;
             at = bytes.find("\nTIS\t", at + 1))
            scatter.push_back(std::stod(bytes.substr(at + 5)));
        const Samples samples = read_samples(ua_loft(name));
        const std::vector<double> integrals =
            test::block_integrals(samples, [](std::size_t) { return 1.0; });
        ASSERT_EQ(integrals.size(), scatter.size()) << name;
        for (std::size_t b = 0; b < scatter.size(); ++b)
            EXPECT_NEAR(integrals[b] / scatter[b], 1, 0.08) << name << " block " << b;
    }
    // What Radiant Imaging published for brown vinyl at 15 degrees, with the cosine.
    const Samples vinyl =
        read_samples(ua_loft("validation__zemax__ValidationTest_of_TIS_via_BrownVinyl.bsdf"));
    const auto reflectance = test::block_integrals(vinyl, [&](std::size_t k) {
        return 2.0 * vinyl.directions->wo(k)[2]; // its mirror image too
    });
    EXPECT_NEAR(reflectance[0], 0.134506, 0.02 * 0.134506);
}

// The same measurements in another format.
TEST_F(Formats, fred_files_agree_with_zemax_files) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* sample : {"AnoBlackEC1onAlum", "AnoBlackNiTEonINVAR"}) {
        const Samples zemax =
            read_samples(ua_loft(fmt::format("processed__zemax__{}.bsdf", sample)));
        const Samples fred = read_samples(ua_loft(fmt::format("processed__fred__{}.txt", sample)));
        std::vector<double> errors;
        for (std::size_t k = 0; k < zemax.count(); ++k) {
            if (zemax.valid[k] == 0)
                continue;
            double least = 1, value = 0;
            for (std::size_t j = 0; j < fred.count(); ++j) {
                // Seen from the other side, and mirrored where the azimuth is negative.
                const auto folded = [](const Vector& v, double x) {
                    return Vector{x * v[0], std::abs(v[1]), v[2]};
                };
                const double distance = 10 * test::distance(zemax.directions->wi(k),
                                                            folded(fred.directions->wi(j), -1)) +
                                        test::distance(folded(zemax.directions->wo(k), 1),
                                                       folded(fred.directions->wo(j), -1));
                if (distance < least) {
                    least = distance;
                    value = fred.values[j];
                }
            }
            if (least < 0.03)
                errors.push_back(std::abs(value / zemax.values[k] - 1));
        }
        ASSERT_GT(errors.size(), 100U);
        std::sort(errors.begin(), errors.end());
        EXPECT_LT(errors[errors.size() / 2], 0.05) << sample;
    }
}

TEST_F(Formats, zemax_header_is_named) {
    refused(changed(zemax_example, "BRDF", "BTDF"), "ScatterType: 'BTDF'; expected BRDF");
    refused(changed(zemax_example, "ASymmetrical", "Round"), "Symmetry: 'Round'");
    refused(changed(zemax_example, "Monochrome", "RGB"), "SpectralContent: 'RGB'");
    refused(changed(zemax_example, "Source\t", "Sauce\t"), "line 2: 'Sauce'; expected a keyword");
    refused(changed(zemax_example, "Rotation\t2", "Rotation\t3"),
            "line 8: column SampleRotation: 'AngleOfIncidence'");
    refused(changed(zemax_example, "Rotation\t2", "Rotation\t0"), "SampleRotation: no angles");
    refused(changed(zemax_example, "Rotation\t2", "Rotation\t1"),
            "SampleRotation: 2 angles; expected 1");
    refused(changed(zemax_example, "Rotation\t2", "Rotation\t99999999999999999999"),
            "whole number");
    refused(changed(zemax_example, "15 30", "15 30,5"), "'30,5'; expected a finite number");
    refused(changed(zemax_example, "15 30", "30 15"), "'15'; expected angles that ascend");
    refused(changed(zemax_example, "15 30", "15 91"), "'91'; expected an angle in [0, 90] degrees");
    refused(changed(zemax_example, "0 30 80", "0 30 nan"), "'nan'; expected a finite number");
    refused(changed(zemax_example, "ScatterRadial\t3\n0 30 80\n", ""),
            "ends without ScatterRadial");
    refused(changed(zemax_example, "\nMonochrome\n", "\nTristimulusX\n"), "expected Monochrome");
    refused(changed(zemax_example, "DataBegin", "Data"), "expected DataBegin");
    refused(changed(zemax_example, "TIS\t0.2", "TIS"), "expected TIS and its value");
    refused(changed(zemax_example, "0.5 0.25", "0.5"), "2 values; expected 3, one for each");
    refused(changed(zemax_example, "0.5 0.25", "0.5 1e39"), "'1e39' is too large");
    refused(changed(zemax_example, "0.5 0.25", "0.5 inf"), "'inf'; expected a finite number");
    refused(changed(zemax_example, "DataEnd", "1 2 3\nDataEnd"), "expected DataEnd");
    refused(changed(zemax_example, "4 0 0\n", ""), "values; expected 3");
    std::string zeros = zemax_example;
    for (std::size_t at = zeros.find("TIS"); at < zeros.size(); ++at)
        if (std::isdigit(static_cast<unsigned char>(zeros[at])) != 0)
            zeros[at] = '0';
    refused(zeros, "only zeros, or directions below the horizon; expected measured values");
}

TEST_F(Formats, fred_is_read) {
    const Samples samples = read(fred_example);
    test::expect_whole(samples, "the example");
    EXPECT_EQ(samples.format, "FRED BSDF text");
    EXPECT_TRUE(samples.isotropic);
    EXPECT_EQ(samples.values, (std::vector<float>{0.5F, 0.25F, 1})); // scaled
    // The file gives the specular direction.
    EXPECT_LT(test::distance(samples.directions->wi(0), at(10, 180)), 1e-6);
    EXPECT_LT(test::distance(samples.directions->wo(1), at(5, 30)), 1e-6);
    EXPECT_LT(test::distance(samples.directions->wo(2), at(20, 270)), 1e-6);
    EXPECT_FALSE(read(changed(fred_example, "30\t0\n", "30\t40\n")).isotropic);
}

TEST_F(Formats, fred_lines_are_named) {
    refused(changed(fred_example, "bsdf=value", "bsdf=log"), "line 2: 'bsdf=log'; expected");
    refused(changed(fred_example, "scale=2", "scale=x"), "line 2: column scale: 'x'");
    refused(changed(fred_example, "angles=deg", "angles=rad"), "expected an angle within");
    refused(changed(fred_example, "10\t0\n", ""), "line 3: a value ahead of its incident");
    refused(changed(fred_example, "0.25", "0,25"), "'0,25'; expected a finite number");
    refused(changed(fred_example, "0.25", "1e39"), "'1e39' is too large");
    refused(changed(fred_example, "-20\t", "-91\t"), "'-91'; expected an angle within");
    refused(changed(fred_example, "0.25", "0.25 1"), "line 4: 4 numbers");
    refused("type bsdf_data\n10 0\n", "no samples");
}

// Another process may write the file between counting and reading.
TEST_F(Formats, rows_of_another_number_than_before_are_refused) {
    const std::string text = "1\n2\n";
    text::Lines lines(text, "file");
    const Vector up{0, 0, 1};
    Rows rows(lines, {"Y"}, 2);
    rows.add(up, up);
    rows.add_value(1);
    test::expect_complaint(complaint([&] { rows.samples("", true); }), "file", "has other rows");
    rows.add(up, up);
    test::expect_complaint(complaint([&] { rows.add(up, up); }), "file", "has other rows");
    EXPECT_EQ(rows.samples("", true).count(), 2U);
}

TEST_F(Formats, alta_is_read) {
    const Samples samples = read(alta_example);
    test::expect_whole(samples, "the example");
    EXPECT_EQ(samples.format, "ALTA text, ISOTROPIC_TL_TV_PROJ_DPHI, values with cos(theta_o)");
    EXPECT_TRUE(samples.isotropic);
    ASSERT_EQ(samples.count(), 3U);
    EXPECT_LT(test::distance(samples.directions->wi(0), direction(0.25, 0)), 1e-6);
    EXPECT_LT(test::distance(samples.directions->wo(0), direction(1, 0)), 1e-6);
    EXPECT_LT(test::distance(samples.directions->wo(1), direction(0.5, std::atan2(0.4, -0.3))),
              1e-6);
    EXPECT_FLOAT_EQ(samples.values[0], static_cast<float>(0.5 / std::cos(1.0)));
    EXPECT_EQ(samples.valid[2], 0) << "no cosine at the horizon";
    const Samples plain =
        read(changed(alta_example, "#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n", ""));
    EXPECT_EQ(plain.values[0], 0.5F);
    EXPECT_EQ(plain.valid[2], 1);
}

TEST_F(Formats, alta_parametrisations_give_the_same_pair) {
    const double ti = 0.3, to = 0.9, phi = 1.1;
    const Vector wi = direction(ti, 0), wo = direction(to, phi);
    const auto expect_pair = [&](const std::string& in, const std::vector<double>& x,
                                 bool isotropic, const Vector& i, const Vector& o) {
        const Samples samples = read(
            fmt::format("#DIM {} 1\n#PARAM_IN {}\n{:.17g} 2\n", x.size(), in, fmt::join(x, " ")));
        EXPECT_LT(test::distance(samples.directions->wi(0), i), 1e-6) << in;
        EXPECT_LT(test::distance(samples.directions->wo(0), o), 1e-6) << in;
        EXPECT_EQ(samples.isotropic, isotropic) << in;
        EXPECT_EQ(samples.values[0], 2);
    };
    expect_pair("ISOTROPIC_TV_TL_DPHI", {to, ti, phi}, true, wi, wo);
    expect_pair("SPHERICAL_TL_PL_TV_PV", {ti, 0.5, to, 0.5 + phi}, false, direction(ti, 0.5),
                direction(to, 0.5 + phi));
    expect_pair("CARTESIAN", {wo[0], wo[1], wo[2], wi[0], wi[1], wi[2]}, false, wi, wo);
    // The light at theta_d from a half vector in the plane of x, towards the horizon.
    expect_pair("RUSIN_TH_TD_PD", {0.4, 0.25, 0}, true, direction(0.65, 0), direction(0.15, 0));
    expect_pair("RUSIN_TH_PH_TD_PD", {0.4, 0.7, 0.25, pi}, false, direction(0.15, 0.7),
                direction(0.65, 0.7));
}

TEST_F(Formats, alta_header_and_rows_are_named) {
    refused(changed(alta_example, "#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n", ""), "no #PARAM_IN");
    refused(changed(alta_example, "#DIM 3 1\n", ""), "no #DIM");
    refused(changed(alta_example, "#DIM 3 1", "#DIM 3"), "#DIM: expected");
    refused(changed(alta_example, "#DIM 3 1", "#DIM 4 1"), "has 3 parameters");
    refused(changed(alta_example, "#DIM 3 1", "#DIM 3 0"), "#DIM: 0 channels");
    refused(changed(alta_example, "#DIM 3 1", "#DIM 3 99999"), "#DIM: 99999 channels");
    refused(changed(alta_example, "#DIM 3 1", "#DIM 3 -1"), "whole number");
    refused(changed(alta_example, "ISOTROPIC_TL_TV_PROJ_DPHI", "COS_TH"), "#PARAM_IN 'COS_TH'");
    refused(changed(alta_example, "INV_STERADIAN_COSINE_FACTOR", "ENERGY"), "#PARAM_OUT 'ENERGY'");
    refused(changed(alta_example, "#VS 0", "#VS 3"), "#VS");
    refused(changed(alta_example, "#VS 0", "#VS 1"), "line 6: 4 fields; expected 5");
    refused(changed(alta_example, "0.4 0.25", "0.4 0,25"), "line 7: column value: '0,25'");
    refused(changed(alta_example, "0.25 1.0", "nan 1.0"), "line 6: column parameter 1: 'nan'");
    refused(changed(alta_example, "0.4 0.25", "0.4 1e39"), "is too large");
    refused(alta_example.substr(0, alta_example.find("0.25")), "no samples");
}

TEST_F(Formats, utia_is_read) {
    Material material;
    write_file(folder / "m.json", test::material_example);
    material = read_material(folder / "m.json");
    Directions pairs(utia::directions * utia::directions);
    for (std::size_t k = 0; k < pairs.count(); ++k) {
        const double i = static_cast<double>(k / 288), o = static_cast<double>(k % 288);
        pairs.set(k, at(15 * std::floor(i / 48), 7.5 * std::fmod(i, 48)),
                  at(15 * std::floor(o / 48), 7.5 * std::fmod(o, 48)));
    }
    const std::vector<float> values = evaluate(test::device(), material, pairs);
    const std::vector<double> wide(values.begin(), values.end());
    std::string bytes(reinterpret_cast<const char*>(wide.data()), wide.size() * sizeof(double));
    const Samples samples = read(bytes);
    test::expect_whole(samples, "a UTIA file");
    EXPECT_EQ(samples.format, "UTIA binary");
    EXPECT_FALSE(samples.isotropic);
    EXPECT_EQ(samples.values, values);
    for (std::size_t k = 0; k < pairs.count(); k += 97) {
        EXPECT_LT(test::distance(samples.directions->wi(k), pairs.wi(k)), 1e-6);
        EXPECT_LT(test::distance(samples.directions->wo(k), pairs.wo(k)), 1e-6);
    }
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double value : {infinity, -infinity, std::nan(""), 1e300}) {
        std::memcpy(bytes.data() + 8000, &value, sizeof value);
        refused(bytes, "byte 8000: ");
    }
    refused(bytes + ' ', "unknown format");
    refused(bytes.substr(1), "unknown format");
}

TEST_F(Formats, text_may_have_carriage_returns_and_a_byte_order_mark) {
    for (const std::string& example : {zemax_example, fred_example, alta_example}) {
        std::string bytes = "\xef\xbb\xbf";
        for (const char c : example)
            bytes += c == '\n' ? std::string("\r\n") : std::string(1, c);
        EXPECT_EQ(read(bytes).values, read(example).values);
    }
}

TEST_F(Formats, cut_and_mutated_files_are_read_or_refused) {
    for (const std::string& example : {zemax_example, fred_example, alta_example}) {
        for (std::size_t size = 1; size < example.size(); ++size)
            expect_read_or_refused(example.substr(0, size));
        test::Mutations mutations(example);
        for (int i = 0; i < 500; ++i)
            expect_read_or_refused(mutations.next());
    }
}

TEST_F(Formats, every_measured_file_is_read) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    std::size_t files = 0;
    for (const char* room : {"rgl", "cornell", "ua-loft", "alta"})
        for (const auto& entry : std::filesystem::directory_iterator(test::data_folder() / room)) {
            const std::string ending = entry.path().extension().string();
            if (ending.empty() || ending == ".exr")
                continue;
            const Samples samples = read_samples(entry.path().string());
            test::expect_whole(samples, entry.path().string());
            EXPECT_GT(samples.valid_count(), (samples.count() + samples.left_out) * 45 / 100)
                << entry.path();
            ++files;
        }
    EXPECT_GT(files, 30U);
}

} // namespace

} // namespace brdfit

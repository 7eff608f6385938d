#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/files/directions.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <random>

namespace brdfit {

namespace {

using test::read_file;
using test::run_program;
using test::TemporaryFolder;
using test::write_file;

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double distance(const Vector& a, const Vector& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// The MERL grid, literally: rotations as Rusinkiewicz describes them, one bin at a time.

struct BinCentre {
    Vector wi, wo, h;
    double c;
};

Vector rotate_y(const Vector& v, double angle) {
    return {std::cos(angle) * v[0] + std::sin(angle) * v[2], v[1],
            -std::sin(angle) * v[0] + std::cos(angle) * v[2]};
}

BinCentre bin_centre(std::size_t bin) {
    const std::size_t row = bin / 180, slice = row / 90;
    const double i = static_cast<double>(slice), j = static_cast<double>(row % 90),
                 k = static_cast<double>(bin % 180);
    const double theta_h = (i + 0.5) / 90 * (i + 0.5) / 90 * pi / 2;
    const double theta_d = (j + 0.5) / 90 * pi / 2, phi_d = (k + 0.5) / 180 * pi;
    const Vector h = rotate_y({0, 0, 1}, theta_h);
    const Vector wi = rotate_y(direction(theta_d, phi_d), theta_h);
    const double c = dot(wi, h);
    return {wi, {2 * c * h[0] - wi[0], 2 * c * h[1] - wi[1], 2 * c * h[2] - wi[2]}, h, c};
}

/// Stored values of a MERL file: positive, different everywhere, -1 below the horizon and wherever
/// `empty` says.
std::vector<double> merl_values() {
    std::vector<double> values(3 * merl::bins);
    for (std::size_t bin = 0; bin < merl::bins; ++bin) {
        const BinCentre centre = bin_centre(bin);
        const bool valid = centre.wi[2] > 0 && centre.wo[2] > 0 && bin % 1000 != 999;
        for (std::size_t c = 0; c < 3; ++c)
            values[c * merl::bins + bin] =
                valid ? 1e-3 * static_cast<double>(bin + 1) * static_cast<double>(c + 1) : -1;
    }
    return values;
}

void write_merl(const std::string& path, const std::vector<double>& values) {
    const std::int32_t dimensions[] = {90, 90, 180};
    std::string bytes(sizeof dimensions + values.size() * sizeof(double), '\0');
    std::memcpy(bytes.data(), dimensions, sizeof dimensions);
    std::memcpy(bytes.data() + sizeof dimensions, values.data(), values.size() * sizeof(double));
    write_file(path, bytes);
}

std::vector<double> stored_values(const std::string& path) {
    const std::string bytes = read_file(path);
    EXPECT_EQ(bytes.size(), 12 + 3 * merl::bins * sizeof(double));
    EXPECT_EQ(bytes.substr(0, 12), std::string("\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0", 12));
    std::vector<double> values(3 * merl::bins);
    std::memcpy(values.data(), bytes.data() + 12, values.size() * sizeof(double));
    return values;
}

/// The values of a float32 .npy file whose header says (rows, columns).
std::vector<float> npy_values(const std::string& path, std::size_t rows, std::size_t columns) {
    const std::string bytes = read_file(path);
    EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    const std::size_t length =
        static_cast<unsigned char>(bytes[8]) + 256U * static_cast<unsigned char>(bytes[9]);
    EXPECT_EQ((10 + length) % 64, 0U);
    const std::string header = bytes.substr(10, length);
    EXPECT_EQ(
        header.find(fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
                                rows, columns)),
        0U);
    EXPECT_EQ(header.back(), '\n');
    EXPECT_EQ(bytes.size(), 10 + length + rows * columns * sizeof(float));
    std::vector<float> values(rows * columns);
    std::memcpy(values.data(), bytes.data() + 10 + length, bytes.size() - 10 - length);
    return values;
}

/// Bytes of a .npy file.
template <typename Number>
std::string npy_file(int version, const std::string& header, const std::vector<Number>& values) {
    std::string bytes = "\x93NUMPY";
    bytes += {static_cast<char>(version), '\0'};
    for (std::size_t i = 0, length = header.size(); i < (version == 1 ? 2U : 4U); ++i)
        bytes += static_cast<char>(length >> 8 * i & 0xff);
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
    return bytes;
}

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

class Measured : public testing::Test {
  protected:
    /// Writes a file and reads it as samples.
    Samples read(const std::string& bytes, std::optional<bool> isotropic = std::nullopt) {
        write_file(folder / "measured.dat", bytes);
        return read_samples(folder / "measured.dat", isotropic);
    }
    Directions directions(const std::string& bytes) {
        write_file(folder / "directions.dat", bytes);
        return read_directions(folder / "directions.dat");
    }
    TemporaryFolder folder;
};

TEST(Directions, HalfVectorComesFromDoublePrecision) {
    // Near grazing wi + wo cancels: from float32 directions the half vector would be off by 1e-4.
    const Vector wi = direction(1.5706, 0), wo = direction(1.5705, pi - 1e-5);
    Directions directions(2);
    directions.set(1, wi, wo);
    Vector h{wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const double length = std::sqrt(dot(h, h));
    for (double& x : h)
        x /= length;
    EXPECT_NEAR(directions.plane(Directions::HX)[1], h[0], 6e-8);
    EXPECT_NEAR(directions.plane(Directions::HY)[1], h[1], 6e-8);
    EXPECT_NEAR(directions.plane(Directions::HZ)[1], h[2], 6e-8);
    EXPECT_NEAR(directions.plane(Directions::C)[1], length / 2, 2e-11);
    EXPECT_LT(distance(directions.wi(1), wi), 1e-7);
    EXPECT_LT(distance(directions.wo(1), wo), 1e-7);

    // The pair brings the half vector back.
    const auto [i, o] = directions.pair(1);
    EXPECT_LT(distance(i, wi), 1e-7);
    EXPECT_LT(distance(o, wo), 1e-7);
    EXPECT_NEAR((i[0] + o[0]) / length, h[0], 2e-7);
    EXPECT_NEAR((i[2] + o[2]) / length, h[2], 2e-7);
    EXPECT_NEAR(dot(i, i), 1, 1e-12);
    EXPECT_NEAR(dot(o, o), 1, 1e-12);
}

TEST(Directions, OppositeDirectionsAreFinite) {
    Directions directions(2);
    directions.set(0, {0, 0, 1}, {0, 0, -1});
    directions.set(1, {1, 0, 0}, {-1, 0, 0});
    for (const float x : directions.data())
        EXPECT_TRUE(std::isfinite(x));
    EXPECT_EQ(directions.pair(0).second[2], -1);
    EXPECT_FALSE(directions.above_horizon(0));
    EXPECT_FALSE(directions.above_horizon(1));
}

TEST(MerlGrid, DirectionsAgreeWithTheLiteralReference) {
    const auto directions = merl::bin_directions();
    ASSERT_EQ(directions->count(), merl::bins);
    EXPECT_EQ(directions, merl::bin_directions());
    double worst = 0;
    for (std::size_t bin = 0; bin < merl::bins; ++bin) {
        const BinCentre centre = bin_centre(bin);
        const double expected[] = {centre.wi[0], centre.wi[1], centre.wi[2], centre.wo[0],
                                   centre.wo[1], centre.wo[2], centre.h[0],  centre.h[1],
                                   centre.h[2],  centre.c};
        for (int p = 0; p < Directions::plane_count; ++p) {
            const double got = directions->plane(static_cast<Directions::Plane>(p))[bin];
            worst = std::max(worst, std::abs(got - expected[p]));
        }
    }
    EXPECT_LT(worst, 6.1e-8);
}

TEST(MerlGrid, AQuarterOfTheBinsIsBelowTheHorizon) {
    const auto directions = merl::bin_directions();
    std::size_t below = 0;
    for (std::size_t bin = 0; bin < merl::bins; ++bin)
        below += !directions->above_horizon(bin);
    EXPECT_NEAR(100.0 * static_cast<double>(below) / static_cast<double>(merl::bins), 24.8, 0.05);
}

TEST(MerlGrid, WeightsAreSolidAngles) {
    const std::vector<float> weights = merl::bin_weights();
    ASSERT_EQ(weights.size(), merl::bins);
    const auto directions = merl::bin_directions();
    double all = 0, above = 0;
    for (std::size_t bin = 0; bin < merl::bins; ++bin) {
        ASSERT_GT(weights[bin], 0);
        all += weights[bin];
        above += directions->above_horizon(bin) ? weights[bin] : 0;
    }
    // 4 times 2 pi for h times, for d, the integral of cos sin (1/2) over half a turn (pi).
    EXPECT_NEAR(all, 4 * pi * pi, 1e-5);
    // wi and wo each cover a hemisphere, 2 pi; the grid holds one order of each pair of them.
    EXPECT_NEAR(above, 2 * pi * pi, 0.005 * 2 * pi * pi);
    // One bin by a fine sum over its inside.
    const int n = 200;
    double bin = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double u = (7 + (i + 0.5) / n) / 90, v = (40 + (j + 0.5) / n) / 90;
            const double theta_h = u * u * pi / 2, theta_d = v * pi / 2;
            bin += 4 * std::cos(theta_d) * (std::sin(theta_h) * 2 * u * pi / 2 * 2 * pi) *
                   (std::sin(theta_d) * pi / 2 * pi / 180) / (90.0 * n * 90.0 * n);
        }
    EXPECT_NEAR(weights[(7 * 90 + 40) * 180 + 33] / bin, 1, 1e-5);
}

TEST(MerlGrid, BinOfABinsCentreIsTheBin) {
    const auto directions = merl::bin_directions();
    std::mt19937 random(1);
    std::uniform_real_distribution<double> azimuth(-pi, pi);
    for (std::size_t bin = 0; bin < merl::bins; ++bin) {
        const BinCentre centre = bin_centre(bin);
        ASSERT_EQ(merl::bin_of(centre.wi, centre.wo), bin);
        ASSERT_EQ(merl::bin_of(centre.wo, centre.wi), bin) << "reciprocity";
        const auto [wi, wo] = directions->pair(bin);
        ASSERT_EQ(merl::bin_of(wi, wo), bin) << "stored directions";
        const double angle = azimuth(random), cos = std::cos(angle), sin = std::sin(angle);
        const auto turn = [&](const Vector& v) {
            return Vector{cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]};
        };
        ASSERT_EQ(merl::bin_of(turn(centre.wi), turn(centre.wo)), bin) << "turned";
    }
}

TEST(MerlGrid, BinOfAnyPairIsInRange) {
    const Vector n{0, 0, 1}, x{1, 0, 0};
    for (const auto& [wi, wo] : std::vector<std::pair<Vector, Vector>>{
             {n, n}, {x, x}, {x, {-1, 0, 0}}, {n, x}, {n, {0, 0, -1}}, {{0, 0, -1}, {0, 0, -1}}})
        EXPECT_LT(merl::bin_of(wi, wo), merl::bins);
}

TEST_F(Measured, MerlIsReadWithItsScales) {
    std::vector<double> values = merl_values();
    const std::size_t bin = 1234567; // above the horizon
    ASSERT_GT(values[bin], 0);
    values[merl::bins + bin + 1] = -0.5; // one negative channel is enough
    values[bin + 2] = 0;
    write_merl(folder / "any.name", values);
    const Samples samples = read_samples(folder / "any.name");
    EXPECT_EQ(samples.source, folder / "any.name");
    EXPECT_EQ(samples.format, "MERL binary");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_TRUE(samples.isotropic);
    EXPECT_EQ(samples.sha256, sha256(read_file(folder / "any.name")));
    EXPECT_EQ(samples.count(), merl::bins);
    EXPECT_EQ(samples.directions, merl::bin_directions());
    EXPECT_EQ(samples.weights, merl::bin_weights());
    std::size_t valid = 0;
    for (std::size_t k = 0; k < merl::bins; ++k) {
        const bool expected = values[k] >= 0 && k != bin + 1;
        ASSERT_EQ(samples.valid[k] != 0, expected) << k;
        valid += expected;
        if (!expected)
            continue;
        ASSERT_FLOAT_EQ(samples.channel(0)[k], static_cast<float>(values[k] / 1500));
        ASSERT_FLOAT_EQ(samples.channel(1)[k],
                        static_cast<float>(values[merl::bins + k] * 1.15 / 1500));
        ASSERT_FLOAT_EQ(samples.channel(2)[k],
                        static_cast<float>(values[2 * merl::bins + k] * 1.66 / 1500));
    }
    EXPECT_EQ(samples.valid_count(), valid);
    EXPECT_EQ(samples.valid[bin + 2], 1) << "0 is a measurement";
}

TEST_F(Measured, MerlBinsBelowTheHorizonAreInvalidWhateverTheyHold) {
    write_merl(folder / "ones.binary", std::vector<double>(3 * merl::bins, 1.0));
    const Samples samples = read_samples(folder / "ones.binary");
    for (std::size_t bin = 0; bin < merl::bins; ++bin)
        ASSERT_EQ(samples.valid[bin] != 0, samples.directions->above_horizon(bin));
}

TEST_F(Measured, MerlSurvivesRoundTrips) {
    const std::vector<double> values = merl_values();
    write_merl(folder / "a.binary", values);
    const Samples a = read_samples(folder / "a.binary");
    write_samples(a, folder / "b.binary");
    write_samples(a, folder / "a.csv", {"what: a test", "two\nlines"});
    const Samples csv = read_samples(folder / "a.csv");
    EXPECT_EQ(csv.format, "scattered CSV");
    EXPECT_TRUE(csv.isotropic);
    EXPECT_EQ(csv.count(), a.valid_count());
    EXPECT_EQ(csv.weights.size(), csv.count());
    write_samples(csv, folder / "c.binary");
    for (const char* name : {"b.binary", "c.binary"}) {
        const std::vector<double> again = stored_values(folder / name);
        for (std::size_t i = 0; i < values.size(); ++i)
            ASSERT_NEAR(again[i], values[i], 1e-7 * std::abs(values[i])) << name << " " << i;
        const Samples b = read_samples(folder / name);
        EXPECT_EQ(b.values.size(), a.values.size());
        EXPECT_EQ(b.valid, a.valid);
        for (std::size_t k = 0; k < a.count(); ++k)
            ASSERT_TRUE(!a.valid[k] || b.channel(2)[k] == a.channel(2)[k]) << k;
    }
    EXPECT_EQ(read_file(folder / "a.csv").find("# what: a test\n# two lines\ntheta_i,phi_i,"), 0U);
}

TEST_F(Measured, ScatteredSamplesAreAveragedIntoBins) {
    // Two samples in one bin, weights 1 and 3; one alone; one negative.
    const Samples samples = read("theta_i,phi_i,theta_o,phi_o,R,G,B,weight\n"
                                 "0.5,0,0.3,3,1,2,3,1\n"
                                 "0.5001,0,0.3,3,5,6,7,3\n"
                                 "0.2,0,0.7,1,1,1,1,1\n"
                                 "1.2,0,0.7,1,-1,1,1,1\n");
    ASSERT_TRUE(samples.isotropic);
    write_samples(samples, folder / "a.binary");
    const Samples grid = read_samples(folder / "a.binary");
    EXPECT_EQ(grid.valid_count(), 3U);
    const std::size_t shared = merl::bin_of(direction(0.5, 0), direction(0.3, 3));
    ASSERT_EQ(merl::bin_of(direction(0.5001, 0), direction(0.3, 3)), shared);
    EXPECT_FLOAT_EQ(grid.channel(0)[shared], 4);
    EXPECT_FLOAT_EQ(grid.channel(1)[shared], 5);
    EXPECT_FLOAT_EQ(grid.channel(2)[shared], 6);
    const std::size_t negative = merl::bin_of(direction(1.2, 0), direction(0.7, 1));
    EXPECT_EQ(grid.channel(0)[negative], 0);
    EXPECT_FLOAT_EQ(grid.channel(1)[negative], 1);
    const std::vector<double> stored = stored_values(folder / "a.binary");
    EXPECT_EQ(stored[(shared + 1) % merl::bins], -1);
}

TEST_F(Measured, MerlHoldsIsotropicDataOfThreeChannels) {
    EXPECT_THROW(write_samples(read(csv_example, false), folder / "a.binary"), InputError);
    EXPECT_THROW(write_samples(read(cornell_example), folder / "a.binary"), InputError);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.binary"));
}

TEST_F(Measured, CsvIsRead) {
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

TEST_F(Measured, CsvTakesWhatProgramsWrite) {
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

TEST_F(Measured, CsvMayHaveWeights) {
    const Samples samples =
        read("theta_i,phi_i,weight,theta_o,phi_o,x\n0.5,0,2,0.25,3,7\n0.5,0,0,1,2,8\n");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"x"}));
    EXPECT_EQ(samples.values, (std::vector<float>{7, 8}));
    EXPECT_EQ(samples.weights, (std::vector<float>{2, 0}));
}

TEST_F(Measured, EqualAzimuthsAreIsotropic) {
    const std::string head = "theta_i,phi_i,theta_o,phi_o,x\n";
    const std::string same = head + "0.5,0.3,0.25,3,7\n0.6,0.3,1,2,8\n";
    const std::string different = head + "0.5,0.3,0.25,3,7\n0.6,0.4,1,2,8\n";
    EXPECT_TRUE(read(same).isotropic);
    EXPECT_TRUE(read(head + "0.5,0,0.25,3,7\n0.6,-0,1,2,8\n").isotropic);
    EXPECT_FALSE(read(different).isotropic);
    EXPECT_FALSE(read(same, false).isotropic);
    EXPECT_TRUE(read(different, true).isotropic);
}

TEST_F(Measured, AngleRoundedAboveHalfPiIsHalfPi) {
    const Samples samples = read("theta_i,phi_i,theta_o,phi_o,x\n1.570797,0,1.5708,3,7\n");
    EXPECT_NEAR(samples.directions->wi(0)[2], 0, 1e-15);
    EXPECT_GE(samples.directions->wo(0)[2], 0);
}

TEST_F(Measured, CsvWrittenKeepsIsotropy) {
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

TEST_F(Measured, CsvWrittenHasWeightsWhereTheyDiffer) {
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

TEST_F(Measured, SamplesAreWrittenAsNpy) {
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

TEST_F(Measured, AstmIsRead) {
    const Samples samples = read(astm_example);
    EXPECT_EQ(samples.format, "ASTM E1392 text");
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"R", "G"}));
    EXPECT_EQ(samples.values, (std::vector<float>{0.011364F, 0.01277F, -0.000779F, 0.000718F}));
    EXPECT_EQ(samples.valid_count(), 2U);
    EXPECT_TRUE(samples.isotropic);
    EXPECT_LT(distance(samples.directions->wi(0), direction(0.872665, 0)), 1e-7);
    EXPECT_LT(distance(samples.directions->wo(1), direction(0.427512, -0.261799)), 1e-7);
}

TEST_F(Measured, CornellIsRead) {
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

TEST_F(Measured, ContentDecidesNotTheName) {
    write_file(folder / "a.binary", csv_example);
    write_file(folder / "a.csv", cornell_example);
    write_file(folder / "a", astm_example);
    EXPECT_EQ(read_samples(folder / "a.binary").format, "scattered CSV");
    EXPECT_EQ(read_samples(folder / "a.csv").format, "Cornell spectral text");
    EXPECT_EQ(read_samples(folder / "a").format, "ASTM E1392 text");
}

TEST_F(Measured, DirectionsAreReadFromCsvAndNpy) {
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

TEST_F(Measured, ColumnsAreWritten) {
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

TEST_F(Measured, NpyHeaderIsAlignedForAnyShape) {
    for (std::size_t rows : {1U, 9U, 10U, 99U, 100U, 12345U, 1234567U}) {
        write_columns(folder / "a.npy", {"x"}, {std::vector<float>(rows, 2.0F)});
        EXPECT_EQ(npy_values(folder / "a.npy", rows, 1).back(), 2.0F);
    }
}

TEST_F(Measured, InfoDescribesAFile) {
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

TEST_F(Measured, InfoGoesOnAfterABadFile) {
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

TEST_F(Measured, ConvertWritesWhereFromAndWhatWith) {
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

TEST_F(Measured, HelpEndsWithAnExample) {
    for (const char* command : {"info", "convert"}) {
        const test::Outcome outcome = run_program({command, "--help"});
        EXPECT_EQ(outcome.status, 0);
        EXPECT_NE(outcome.out.find(fmt::format("Example:\n  brdfit {} ", command)),
                  std::string::npos);
    }
}

TEST_F(Measured, PublishedCornellFiles) {
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

// MERL's grid of directions, and its files.

#include "host/files/file.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "tests/support/measured.hpp"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <random>

namespace brdfit::test {

namespace {

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
    write_file(path,
               merl_header(90, 90, 180) + std::string(reinterpret_cast<const char*>(values.data()),
                                                      values.size() * sizeof(double)));
}

std::vector<double> stored_values(const std::string& path) {
    const std::string bytes = read_file(path);
    EXPECT_EQ(bytes.size(), 12 + 3 * merl::bins * sizeof(double));
    EXPECT_EQ(bytes.substr(0, 12), std::string("\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0", 12));
    std::vector<double> values(3 * merl::bins);
    std::memcpy(values.data(), bytes.data() + 12, values.size() * sizeof(double));
    return values;
}

using Merl = Measured;

TEST(Directions, half_vector_comes_from_double_precision) {
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

TEST(Directions, opposite_directions_are_finite) {
    Directions directions(2);
    directions.set(0, {0, 0, 1}, {0, 0, -1});
    directions.set(1, {1, 0, 0}, {-1, 0, 0});
    for (const float x : directions.data())
        EXPECT_TRUE(std::isfinite(x));
    EXPECT_EQ(directions.pair(0).second[2], -1);
    EXPECT_FALSE(directions.above_horizon(0));
    EXPECT_FALSE(directions.above_horizon(1));
}

TEST(MerlGrid, directions_agree_with_the_literal_reference) {
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

TEST(MerlGrid, a_quarter_of_the_bins_is_below_the_horizon) {
    const auto directions = merl::bin_directions();
    std::size_t below = 0;
    for (std::size_t bin = 0; bin < merl::bins; ++bin)
        below += !directions->above_horizon(bin);
    EXPECT_NEAR(100.0 * static_cast<double>(below) / static_cast<double>(merl::bins), 24.8, 0.05);
}

TEST(MerlGrid, weights_are_solid_angles) {
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

TEST(MerlGrid, bin_of_a_bins_centre_is_the_bin) {
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

TEST(MerlGrid, bin_of_any_pair_is_in_range) {
    const Vector n{0, 0, 1}, x{1, 0, 0};
    for (const auto& [wi, wo] : std::vector<std::pair<Vector, Vector>>{
             {n, n}, {x, x}, {x, {-1, 0, 0}}, {n, x}, {n, {0, 0, -1}}, {{0, 0, -1}, {0, 0, -1}}})
        EXPECT_LT(merl::bin_of(wi, wo), merl::bins);
}

TEST_F(Merl, is_read_with_its_scales) {
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

TEST_F(Merl, bins_below_the_horizon_are_invalid_whatever_they_hold) {
    write_merl(folder / "ones.binary", std::vector<double>(3 * merl::bins, 1.0));
    const Samples samples = read_samples(folder / "ones.binary");
    for (std::size_t bin = 0; bin < merl::bins; ++bin)
        ASSERT_EQ(samples.valid[bin] != 0, samples.directions->above_horizon(bin));
}

TEST_F(Merl, survives_round_trips) {
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

TEST_F(Merl, averages_scattered_samples_into_bins) {
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

TEST_F(Merl, holds_isotropic_data_of_three_channels) {
    const std::string head = "theta_i,phi_i,theta_o,phi_o,";
    EXPECT_THROW(
        write_samples(read(head + "R,G,B\n0.5,0,0.25,3,0.1,0.2,0.3\n", false), folder / "a.binary"),
        InputError);
    EXPECT_THROW(
        write_samples(read(head + "R,G,B,N\n0.5,0,0.25,3,0.1,0.2,0.3,0.4\n"), folder / "a.binary"),
        InputError);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.binary"));
}

} // namespace

} // namespace brdfit::test

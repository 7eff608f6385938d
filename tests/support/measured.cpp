#include "tests/support/measured.hpp"

#include <cmath>
#include <cstring>
#include <fmt/format.h>

namespace brdfit::test {

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double distance(const Vector& a, const Vector& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

Samples Measured::read(const std::string& bytes, std::optional<bool> isotropic) {
    write_file(folder / "measured.dat", bytes);
    return read_samples(folder / "measured.dat", isotropic);
}

Directions Measured::directions(const std::string& bytes) {
    write_file(folder / "directions.dat", bytes);
    return read_directions(folder / "directions.dat");
}

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

void expect_whole(const Samples& samples, const std::string& what) {
    const std::size_t count = samples.count();
    EXPECT_GT(count, 0U) << what;
    EXPECT_FALSE(samples.channels.empty()) << what;
    ASSERT_EQ(samples.values.size(), samples.channels.size() * count) << what;
    ASSERT_EQ(samples.valid.size(), count) << what;
    ASSERT_EQ(samples.directions->data().size(), Directions::plane_count * count) << what;
    ASSERT_TRUE(samples.weights.empty() || samples.weights.size() == count) << what;
    for (std::size_t k = 0; k < count; ++k) {
        if (samples.valid[k] == 0)
            continue;
        for (std::size_t ch = 0; ch < samples.channels.size(); ++ch)
            ASSERT_TRUE(std::isfinite(samples.channel(ch)[k])) << what;
        for (int p = 0; p < Directions::plane_count; ++p)
            ASSERT_TRUE(
                std::isfinite(samples.directions->plane(static_cast<Directions::Plane>(p))[k]))
                << what;
        ASSERT_TRUE(samples.directions->above_horizon(k)) << what;
        const float weight = samples.weights.empty() ? 1 : samples.weights[k];
        ASSERT_TRUE(std::isfinite(weight) && weight >= 0) << what;
    }
}

std::vector<double> block_integrals(const Samples& samples,
                                    const std::function<double(std::size_t)>& function) {
    std::vector<double> sums, thetas;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        const Vector wi = samples.directions->wi(k);
        if (k == 0 || distance(wi, samples.directions->wi(k - 1)) > 1e-6) {
            sums.push_back(0);
            thetas.push_back(std::acos(wi[2]));
        }
        sums.back() += samples.weights[k] * samples.values[k] * samples.valid[k] * function(k);
    }
    // What the weights have of wi: the solid angle that it is nearest to.
    std::size_t incidences = 1;
    while (incidences < thetas.size() && thetas[incidences] > thetas[incidences - 1])
        ++incidences;
    const std::size_t rotations = thetas.size() / incidences;
    for (std::size_t b = 0; b < sums.size(); ++b) {
        const std::size_t i = b % incidences, r = b / incidences;
        const double least = i == 0 ? 0 : (thetas[i - 1] + thetas[i]) / 2;
        const double most = i + 1 == incidences ? pi / 2 : (thetas[i] + thetas[i + 1]) / 2;
        const double turn = rotations == 1 ? 2 * pi
                                           : 2 * pi / static_cast<double>(rotations - 1) *
                                                 (r == 0 || r + 1 == rotations ? 0.5 : 1);
        sums[b] /= turn * (std::cos(least) - std::cos(most));
    }
    return sums;
}

} // namespace brdfit::test

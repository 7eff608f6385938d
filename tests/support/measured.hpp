#pragma once

#include "host/directions.hpp"
#include "host/files/directions.hpp"
#include "host/measured/read.hpp"
#include "tests/support/examples.hpp"
#include "tests/support/support.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <vector>

// What the tests of measured files and of directions share.

namespace brdfit::test {

double dot(const Vector& a, const Vector& b);
double distance(const Vector& a, const Vector& b);

/// A folder for files to read.
class Measured : public testing::Test {
  protected:
    /// Writes a file and reads it as samples.
    Samples read(const std::string& bytes, std::optional<bool> isotropic = std::nullopt);
    Directions directions(const std::string& bytes);

    TemporaryFolder folder;
};

/// The values of a float32 .npy file whose header says (rows, columns).
std::vector<float> npy_values(const std::string& path, std::size_t rows, std::size_t columns);
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

/// Fails where samples are not what every consumer relies on: sizes that agree, and valid samples
/// above the horizon whose values, directions and weights are finite.
void expect_whole(const Samples& samples, const std::string& what);

/// For each wi of a Zemax file, in the file's order, the integral over the wo that it lists of f
/// times a function of the sample. Its rotations are evenly spaced over the circle.
std::vector<double> block_integrals(const Samples& samples,
                                    const std::function<double(std::size_t)>& function);

} // namespace brdfit::test

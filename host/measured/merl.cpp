#include "host/measured/merl.hpp"

#include "host/error.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <future>
#include <spdlog/spdlog.h>

namespace brdfit::merl {

namespace {

constexpr std::size_t channel_count = 3;
constexpr const char* channel_names[channel_count] = {"R", "G", "B"};
constexpr double scale[channel_count] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
constexpr std::size_t slice = std::size_t{theta_d_bins} * phi_d_bins; // bins of one theta_h
constexpr std::size_t header_bytes = 3 * sizeof(std::int32_t);
constexpr std::size_t file_bytes = header_bytes + channel_count * bins * sizeof(double);

/// theta_h at `i` bins from the normal; fractions lie inside a bin.
double theta_h_at(double i) {
    return (i / theta_h_bins) * (i / theta_h_bins) * pi / 2;
}
double theta_d_at(double i) {
    return i / theta_d_bins * pi / 2;
}
double phi_d_at(double i) {
    return i / phi_d_bins * pi;
}

/// A dimension of the header.
std::int32_t dimension(std::string_view bytes, std::size_t i) {
    std::int32_t value;
    std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
    return value;
}

std::string bin_name(std::size_t bin) {
    return fmt::format("bin (theta_h {}, theta_d {}, phi_d {})", bin / phi_d_bins / theta_d_bins,
                       bin / phi_d_bins % theta_d_bins, bin % phi_d_bins);
}

/// Stored value of a plane; the data is not aligned.
double stored(const char* plane, std::size_t bin) {
    double value;
    std::memcpy(&value, plane + bin * sizeof value, sizeof value);
    return value;
}

/// Scales the bins [begin, end) of a plane to 1/sr and clears `valid` where a value is negative.
/// Returns whether every value is a finite float.
bool convert(const char* plane, double factor, std::size_t begin, std::size_t end, float* values,
             std::uint8_t* valid) {
    bool finite = true;
    for (std::size_t bin = begin; bin < end; ++bin) {
        const double value = stored(plane, bin) * factor;
        values[bin] = static_cast<float>(value);
        finite &= std::abs(value) <= FLT_MAX;
        valid[bin] &= static_cast<std::uint8_t>(value >= 0);
    }
    return finite;
}

const char* plane_of(const MappedFile& file, std::size_t channel) {
    return file.bytes().data() + header_bytes + channel * bins * sizeof(double);
}

[[noreturn]] void report_not_finite(const MappedFile& file, std::size_t channel) {
    const char* plane = plane_of(file, channel);
    std::size_t bin = 0;
    while (std::abs(stored(plane, bin) * scale[channel]) <= FLT_MAX)
        ++bin;
    throw InputError(fmt::format("{}: channel {}, {}: {}; expected a finite number", file.path(),
                                 channel_names[channel], bin_name(bin), stored(plane, bin)));
}

Directions make_bin_directions() {
    std::array<double, phi_d_bins> cos_phi, sin_phi;
    for (std::size_t i = 0; i < phi_d_bins; ++i) {
        cos_phi[i] = std::cos(phi_d_at(static_cast<double>(i) + 0.5));
        sin_phi[i] = std::sin(phi_d_at(static_cast<double>(i) + 0.5));
    }
    Directions directions = Directions::unfilled(bins);
    parallel_pieces(theta_h_bins, 1, [&](std::size_t ih, std::size_t) {
        std::array<float*, Directions::plane_count> plane;
        for (std::size_t p = 0; p < plane.size(); ++p)
            plane[p] = directions.plane(static_cast<Directions::Plane>(p)) + ih * slice;
        const double theta_h = theta_h_at(static_cast<double>(ih) + 0.5);
        const double cos_h = std::cos(theta_h), sin_h = std::sin(theta_h);
        for (int id = 0; id < theta_d_bins; ++id) {
            const double cos_d = std::cos(theta_d_at(id + 0.5));
            const double sin_d = std::sin(theta_d_at(id + 0.5));
            // wi and wo are cos(theta_d) h + t and cos(theta_d) h - t, t perpendicular to h.
            const double along_x = cos_d * sin_h, along_z = cos_d * cos_h;
            for (std::size_t i = 0; i < phi_d_bins; ++i) {
                const double x = sin_d * cos_phi[i] * cos_h, y = sin_d * sin_phi[i],
                             z = -sin_d * cos_phi[i] * sin_h;
                plane[Directions::WiX][i] = static_cast<float>(along_x + x);
                plane[Directions::WiY][i] = static_cast<float>(y);
                plane[Directions::WiZ][i] = static_cast<float>(along_z + z);
                plane[Directions::WoX][i] = static_cast<float>(along_x - x);
                plane[Directions::WoY][i] = static_cast<float>(-y);
                plane[Directions::WoZ][i] = static_cast<float>(along_z - z);
                plane[Directions::HX][i] = static_cast<float>(sin_h);
                plane[Directions::HY][i] = 0;
                plane[Directions::HZ][i] = static_cast<float>(cos_h);
                plane[Directions::C][i] = static_cast<float>(cos_d);
            }
            for (float*& p : plane)
                p += phi_d_bins;
        }
    });
    return directions;
}

} // namespace

std::shared_ptr<const Directions> bin_directions() {
    static const auto directions = std::make_shared<const Directions>(make_bin_directions());
    return directions;
}

std::vector<float> bin_weights() {
    std::vector<float> weights;
    weights.reserve(bins);
    for (int ih = 0; ih < theta_h_bins; ++ih) {
        const double dw_h = 2 * pi * (std::cos(theta_h_at(ih)) - std::cos(theta_h_at(ih + 1)));
        for (int id = 0; id < theta_d_bins; ++id) {
            // The integral of cos(theta_d) sin(theta_d) over the bin is half the step of sin^2.
            const double lower = std::sin(theta_d_at(id)), upper = std::sin(theta_d_at(id + 1));
            const double cos_dw_d = (upper * upper - lower * lower) / 2 * pi / phi_d_bins;
            weights.insert(weights.end(), phi_d_bins, static_cast<float>(4 * dw_h * cos_dw_d));
        }
    }
    return weights;
}

std::array<double, 3> bin_coordinates(const Vector& wi, const Vector& wo) {
    const Vector sum{wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const Vector difference{wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]};
    const double radius = std::hypot(sum[0], sum[1]);
    const double theta_h = std::atan2(radius, sum[2]);
    const double theta_d = std::atan2(std::hypot(difference[0], difference[1], difference[2]),
                                      std::hypot(sum[0], sum[1], sum[2]));
    const double cos_phi = radius > 0 ? sum[0] / radius : 1;
    const double sin_phi = radius > 0 ? sum[1] / radius : 0;
    const double x = std::cos(theta_h) * (cos_phi * difference[0] + sin_phi * difference[1]) -
                     std::sin(theta_h) * difference[2];
    const double y = cos_phi * difference[1] - sin_phi * difference[0];
    double phi_d = std::atan2(y, x);
    if (phi_d < 0)
        phi_d += pi; // reciprocity: wi and wo may change places
    if (phi_d >= pi)
        phi_d = 0; // pi is 0 again
    return {std::sqrt(theta_h / (pi / 2)) * theta_h_bins, theta_d / (pi / 2) * theta_d_bins,
            phi_d / pi * phi_d_bins};
}

std::size_t bin_of(const Vector& wi, const Vector& wo) {
    const auto [h, d, p] = bin_coordinates(wi, wo);
    const auto index = [](double at, int count) {
        return static_cast<std::size_t>(std::min(std::max(at, 0.0), count - 1.0));
    };
    return (index(h, theta_h_bins) * theta_d_bins + index(d, theta_d_bins)) * phi_d_bins +
           index(p, phi_d_bins);
}

bool recognise(std::string_view bytes) {
    if (bytes.size() == file_bytes)
        return true;
    if (bytes.size() < sizeof(std::int32_t))
        return false;
    if (dimension(bytes, 0) == theta_h_bins)
        return true;
    if (bytes.size() < header_bytes)
        return false;
    const std::int32_t h = dimension(bytes, 0), d = dimension(bytes, 1), p = dimension(bytes, 2);
    const auto small = [](std::int32_t n) { return n > 0 && n < 65536; };
    return (d == theta_d_bins && p == phi_d_bins) || (small(h) && small(d) && small(p));
}

Samples read(const MappedFile& file) {
    const std::string_view bytes = file.bytes();
    if (bytes.size() < header_bytes)
        throw InputError(fmt::format("{}: header: the file ends after {} bytes; expected {}",
                                     file.path(), bytes.size(), file_bytes));
    const std::int32_t h = dimension(bytes, 0), d = dimension(bytes, 1), p = dimension(bytes, 2);
    if (h != theta_h_bins || d != theta_d_bins || p != phi_d_bins)
        throw InputError(fmt::format("{}: header: dimensions are {}x{}x{}; expected {}x{}x{}",
                                     file.path(), h, d, p, theta_h_bins, theta_d_bins, phi_d_bins));
    if (bytes.size() != file_bytes)
        throw InputError(fmt::format(
            "{}: the file {} {} bytes; expected {} (3 channels of {} bins)", file.path(),
            bytes.size() < file_bytes ? "ends after" : "has", bytes.size(), file_bytes, bins));
    Samples samples;
    samples.format = "MERL binary";
    samples.channels.assign(std::begin(channel_names), std::end(channel_names));
    samples.isotropic = true;
    auto directions = std::async(bin_directions);
    samples.weights = bin_weights();
    samples.valid.assign(bins, 1);
    samples.values.resize(channel_count * bins);
    std::array<std::atomic<bool>, channel_count> finite{true, true, true};
    parallel_pieces(bins, slice, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = 0; c < channel_count; ++c)
            if (!convert(plane_of(file, c), scale[c], begin, end, samples.values.data() + c * bins,
                         samples.valid.data()))
                finite[c] = false;
    });
    for (std::size_t c = 0; c < channel_count; ++c)
        if (!finite[c])
            report_not_finite(file, c);
    samples.directions = directions.get();
    parallel_pieces(bins, slice, [&](std::size_t begin, std::size_t end) {
        for (std::size_t bin = begin; bin < end; ++bin)
            samples.valid[bin] &= static_cast<std::uint8_t>(samples.directions->above_horizon(bin));
    });
    return samples;
}

void write(const Samples& samples, const std::string& path) {
    OutputFile file(path);
    const std::int32_t dimensions[] = {theta_h_bins, theta_d_bins, phi_d_bins};
    file.write(dimensions, sizeof dimensions);
    std::vector<double> plane(bins);
    std::size_t negative = 0;
    for (std::size_t c = 0; c < channel_count; ++c) {
        const float* values = samples.channel(c);
        for (std::size_t bin = 0; bin < bins; ++bin) {
            plane[bin] = -1;
            if (samples.valid[bin]) {
                // a negative value would mark the bin as invalid
                negative += values[bin] < 0;
                plane[bin] = std::max(0.0, values[bin] / scale[c]);
            }
        }
        file.write(plane.data(), plane.size() * sizeof(double));
    }
    file.commit();
    if (negative > 0)
        spdlog::warn("{}: {} negative values became 0: the MERL format has none", path, negative);
}

} // namespace brdfit::merl

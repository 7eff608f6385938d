#include "host/directions.hpp"
#include "host/image/difference.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

// The sections named are those of Andersson et al. 2020.

namespace brdfit {

namespace {

using Plane = std::vector<float>;
using Colour = std::array<double, 3>;

struct Size {
    std::size_t width, height;
};

/// A filter's values at -radius..radius.
using Taps = std::vector<double>;

constexpr double q_colour = 0.7, cut_share = 0.4, cut_value = 0.95; // q_c, p_c, p_t
constexpr double feature_width = 0.082, q_feature = 0.5;            // w in degrees, q_f

Colour xyz_of(const Colour& rgb) { // sRGB's primaries
    return {(10135552 * rgb[0] + 8788810 * rgb[1] + 4435075 * rgb[2]) / 24577794,
            (2613072 * rgb[0] + 8788810 * rgb[1] + 887015 * rgb[2]) / 12288897,
            (1425312 * rgb[0] + 8788810 * rgb[1] + 70074185 * rgb[2]) / 73733382};
}

Colour rgb_of(const Colour& xyz) { // its inverse
    return {3.241003275 * xyz[0] - 1.537398934 * xyz[1] - 0.498615861 * xyz[2],
            -0.969224334 * xyz[0] + 1.875929978 * xyz[1] + 0.041554226 * xyz[2],
            0.055639423 * xyz[0] - 0.204011202 * xyz[1] + 1.057148933 * xyz[2]};
}

const Colour white = xyz_of({1, 1, 1});

/// The linear opponent space in which contrast is filtered: Y, red to green, blue to yellow.
Colour ycxcz_of(const Colour& rgb) {
    const Colour xyz = xyz_of(rgb);
    const double x = xyz[0] / white[0], y = xyz[1] / white[1], z = xyz[2] / white[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Colour rgb_of_ycxcz(const Colour& c) {
    const double y = (c[0] + 16) / 116;
    return rgb_of({(y + c[1] / 500) * white[0], y * white[1], (y - c[2] / 200) * white[2]});
}

/// CIELAB with a and b smaller in the dark (Hunt 1952).
Colour hunt_lab_of(const Colour& rgb) {
    constexpr double knee = 6.0 / 29;
    Colour f = xyz_of(rgb);
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = f[k] / white[k];
        f[k] = x > knee * knee * knee ? std::cbrt(x) : x / (3 * knee * knee) + 4.0 / 29;
    }
    const double l = 116 * f[1] - 16;
    return {l, 0.01 * l * 500 * (f[0] - f[1]), 0.01 * l * 200 * (f[1] - f[2])};
}

double hyab(const Colour& a, const Colour& b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

/// Each row, then each column, with pixels at the border repeated.
Plane filtered(const Plane& plane, const Size& size, const Taps& across, const Taps& down) {
    Plane half(plane.size()), made(plane.size());
    const auto pass = [&size](const Plane& from, Plane& to, const Taps& taps, bool along_x) {
        const auto radius = static_cast<std::ptrdiff_t>(taps.size() / 2);
        const auto last = static_cast<std::ptrdiff_t>(along_x ? size.width : size.height) - 1;
        parallel_pieces(size.height, 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y)
                for (std::size_t x = 0; x < size.width; ++x) {
                    const auto middle = static_cast<std::ptrdiff_t>(along_x ? x : y);
                    double sum = 0;
                    for (std::ptrdiff_t k = -radius; k <= radius; ++k) {
                        const auto at = static_cast<std::size_t>(
                            std::clamp<std::ptrdiff_t>(middle + k, 0, last));
                        sum += taps[static_cast<std::size_t>(k + radius)] *
                               from[along_x ? y * size.width + at : at * size.width + x];
                    }
                    to[y * size.width + x] = static_cast<float>(sum);
                }
        });
    };
    pass(plane, half, across, true);
    pass(half, made, down, false);
    return made;
}

Taps gaussian(std::ptrdiff_t radius, double by_square) { // exp(-by_square x^2), sum 1
    Taps taps;
    double sum = 0;
    for (std::ptrdiff_t k = -radius; k <= radius; ++k) {
        taps.push_back(std::exp(-by_square * static_cast<double>(k * k)));
        sum += taps.back();
    }
    for (double& tap : taps)
        tap /= sum;
    return taps;
}

/// Scales the positive taps to a sum of 1 and the negative ones to -1.
Taps balanced(Taps taps) {
    double above = 0, below = 0;
    for (const double tap : taps)
        (tap > 0 ? above : below) += tap;
    for (double& tap : taps)
        tap /= tap > 0 ? above : -below;
    return taps;
}

/// Contrast sensitivity of one channel: a sum of two Gaussians of frequency (Section 4.1, Table 1),
/// here of pixels.
Plane as_seen(const Plane& plane, const Size& size, std::size_t channel, double pixels_a_degree) {
    struct Term {
        double a, b;
    };
    constexpr Term terms[3][2] = {
        {{1, 0.0047}, {0, 1e-5}}, {{1, 0.0053}, {0, 1e-5}}, {{34.1, 0.04}, {13.5, 0.025}}};
    constexpr double widest = 0.04;
    const auto radius = static_cast<std::ptrdiff_t>(
        std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * pixels_a_degree));
    Plane made(plane.size());
    double weights = 0;
    for (const Term& term : terms[channel]) {
        if (term.a == 0)
            continue;
        const double by_square = pi * pi / (term.b * pixels_a_degree * pixels_a_degree);
        const Taps taps = gaussian(radius, by_square);
        // exp(0) over the middle tap is the sum before it was scaled to 1.
        const double sum = 1 / taps[static_cast<std::size_t>(radius)];
        const double weight = term.a * std::sqrt(pi / term.b) * sum * sum;
        const Plane part = filtered(plane, size, taps, taps);
        for (std::size_t i = 0; i < made.size(); ++i)
            made[i] += static_cast<float>(weight * part[i]);
        weights += weight;
    }
    for (float& value : made)
        value = static_cast<float>(value / weights);
    return made;
}

/// Lengths of a pair of filtered planes, which see edges or points across and down.
Plane lengths(const Plane& luminance, const Size& size, const Taps& along, const Taps& smooth) {
    const Plane x = filtered(luminance, size, along, smooth);
    const Plane y = filtered(luminance, size, smooth, along);
    Plane made(x.size());
    for (std::size_t i = 0; i < made.size(); ++i)
        made[i] = std::hypot(x[i], y[i]);
    return made;
}

struct Seen {
    std::array<Plane, 3> colour; ///< R, G, B after the eye's filter
    Plane edges, points;         ///< of the luminance
};

Seen seen(const Image& image, double pixels_a_degree) {
    const Size size{image.width, image.height};
    const std::size_t count = size.width * size.height;
    std::array<Plane, 3> opponent{Plane(count), Plane(count), Plane(count)};
    Plane luminance(count);
    const std::array<const Plane*, 3> rgb{image.plane("R"), image.plane("G"), image.plane("B")};
    for (std::size_t i = 0; i < count; ++i) {
        const Colour c = ycxcz_of({(*rgb[0])[i], (*rgb[1])[i], (*rgb[2])[i]});
        for (std::size_t ch = 0; ch < 3; ++ch)
            opponent[ch][i] = static_cast<float>(c[ch]);
        luminance[i] = static_cast<float>((c[0] + 16) / 116);
    }
    Seen made;
    for (std::size_t ch = 0; ch < 3; ++ch)
        made.colour[ch] = as_seen(opponent[ch], size, ch, pixels_a_degree);
    for (std::size_t i = 0; i < count; ++i) {
        const Colour c = rgb_of_ycxcz({made.colour[0][i], made.colour[1][i], made.colour[2][i]});
        for (std::size_t ch = 0; ch < 3; ++ch)
            made.colour[ch][i] = static_cast<float>(std::clamp(c[ch], 0.0, 1.0));
    }
    // Section 4.2: first and second derivatives of a Gaussian.
    const double deviation = 0.5 * feature_width * pixels_a_degree;
    const auto radius = static_cast<std::ptrdiff_t>(std::ceil(3 * deviation));
    const Taps smooth = gaussian(radius, 0.5 / (deviation * deviation));
    Taps edge = smooth, point = smooth;
    for (std::ptrdiff_t k = -radius; k <= radius; ++k) {
        const auto x = static_cast<double>(k);
        edge[static_cast<std::size_t>(k + radius)] *= -x;
        point[static_cast<std::size_t>(k + radius)] *= x * x / (deviation * deviation) - 1;
    }
    made.edges = lengths(luminance, size, balanced(edge), smooth);
    made.points = lengths(luminance, size, balanced(point), smooth);
    return made;
}

/// A colour difference compressed and stretched to [0, 1] (Section 4.1, redistribution).
double redistributed(double difference, double most) {
    const double powered = std::pow(difference, q_colour), cut = cut_share * most;
    return powered < cut ? cut_value / cut * powered
                         : cut_value + (powered - cut) / (most - cut) * (1 - cut_value);
}

} // namespace

std::vector<float> flip(const Image& reference, const Image& test, double pixels_a_degree) {
    require_rgb_of_one_size(reference, test);
    const Seen a = seen(reference, pixels_a_degree), b = seen(test, pixels_a_degree);
    const double most = std::pow(hyab(hunt_lab_of({0, 1, 0}), hunt_lab_of({0, 0, 1})), q_colour);
    std::vector<float> made(a.edges.size());
    parallel_pieces(made.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double colour =
                hyab(hunt_lab_of({a.colour[0][i], a.colour[1][i], a.colour[2][i]}),
                     hunt_lab_of({b.colour[0][i], b.colour[1][i], b.colour[2][i]}));
            const double feature =
                std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
            const double of_feature = std::pow(feature / std::sqrt(2.0), q_feature);
            made[i] = static_cast<float>(
                std::pow(redistributed(colour, most), std::max(0.0, 1 - of_feature)));
        }
    });
    return made;
}

} // namespace brdfit

#include "host/render/environment.hpp"

#include "host/directions.hpp"
#include "host/error.hpp"
#include "host/image/image.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <numeric>

namespace brdfit {

namespace {

constexpr double most_radiance = 1e30; // what float32 can sum and square the root of

double mean(const Rgb& rgb) {
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

/// Fills an environment by a function of the unit direction to a texel's middle.
Environment filled(std::string name, std::size_t height,
                   const std::function<Rgb(const Vector&)>& radiance) {
    Environment environment;
    environment.name = std::move(name);
    environment.width = 2 * height;
    environment.height = height;
    environment.texels.resize(2 * height * height);
    for (std::size_t row = 0; row < height; ++row)
        for (std::size_t column = 0; column < environment.width; ++column) {
            const double theta =
                pi * (static_cast<double>(row) + 0.5) / static_cast<double>(height);
            const double phi =
                pi - pi * (static_cast<double>(column) + 0.5) / static_cast<double>(height);
            environment.texels[row * environment.width + column] = radiance(direction(theta, phi));
        }
    return environment;
}

double dot(const Vector& a, const Vector& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Relative luminance of CIE S 011's type 12, its gradation times its indicatrix, before scaling.
double clear_sky(double cos_zenith, double from_sun) {
    const double gradation = 1 - std::exp(-0.32 / std::max(cos_zenith, 0.01));
    const double indicatrix = 1 + 10 * (std::exp(-3 * from_sun) - std::exp(-1.5 * pi)) +
                              0.45 * std::pow(std::cos(from_sun), 2);
    return gradation * indicatrix;
}

} // namespace

double Environment::solid_angle(std::size_t row) const {
    const double step = pi / static_cast<double>(height);
    return 2 * pi / static_cast<double>(width) *
           (std::cos(step * static_cast<double>(row)) -
            std::cos(step * static_cast<double>(row + 1)));
}

Rgb Environment::flux() const {
    Rgb sum{};
    for (std::size_t i = 0; i < texels.size(); ++i)
        for (std::size_t ch = 0; ch < 3; ++ch)
            sum[ch] += texels[i][ch] * solid_angle(i / width);
    return sum;
}

Environment read_environment(const std::string& path) {
    const Image image = read_exr(path);
    const auto fail = [&](const std::string& what) {
        return InputError(fmt::format("{}: no environment map: {}", path, what));
    };
    if (image.width != 2 * image.height)
        throw fail(
            fmt::format("{} x {} pixels; expected twice as wide as high, all azimuths by all "
                        "angles from the zenith",
                        image.width, image.height));
    std::array<const std::vector<float>*, 3> planes{image.plane("R"), image.plane("G"),
                                                    image.plane("B")};
    if (const std::vector<float>* grey = image.plane("Y"); grey != nullptr && planes[0] == nullptr)
        planes = {grey, grey, grey};
    if (std::count(planes.begin(), planes.end(), nullptr) > 0)
        throw fail(
            fmt::format("channels {}; expected R, G and B, or Y", fmt::join(image.channels, ", ")));
    Environment environment;
    environment.name = std::filesystem::path(path).filename().string();
    environment.width = image.width;
    environment.height = image.height;
    environment.texels.resize(image.width * image.height);
    for (std::size_t i = 0; i < environment.texels.size(); ++i)
        for (std::size_t ch = 0; ch < 3; ++ch) {
            const double value = (*planes[ch])[i];
            if (!(value >= 0 && value <= most_radiance))
                throw fail(fmt::format("pixel ({}, {}) is {}; expected radiances from 0 to {:g}",
                                       i % image.width, i / image.width, value, most_radiance));
            environment.texels[i][ch] = value;
        }
    if (mean(environment.flux()) <= 0)
        throw fail("it is black; expected some light");
    return environment;
}

Environment sky_environment() {
    constexpr double elevation = 40 * degree, azimuth = -135 * degree, sun_radius = 1.2 * degree;
    const Vector sun = direction(pi / 2 - elevation, azimuth);
    const double scale = 0.35 / clear_sky(1, pi / 2 - elevation);
    return filled("sky", 256, [=](const Vector& to) -> Rgb {
        const double from_sun = std::acos(std::clamp(dot(to, sun), -1.0, 1.0));
        if (to[2] <= 0) // ground, a little darker far below
            return {0.16 + 0.04 * to[2], 0.14 + 0.04 * to[2], 0.12 + 0.04 * to[2]};
        const double luminance = scale * clear_sky(to[2], from_sun);
        // Blue above, whiter towards the horizon and the sun.
        const double white = std::max(std::exp(-3 * to[2]), std::exp(-4 * from_sun));
        Rgb rgb{luminance * (0.45 + 0.55 * white), luminance * (0.75 + 0.25 * white),
                luminance * (1.5 - 0.5 * white)};
        if (from_sun < sun_radius)
            rgb = {900, 830, 700};
        return rgb;
    });
}

Environment soft_box_environment() {
    struct Panel {
        double theta, phi, half_width, half_height, edge, radiance; // degrees
    };
    constexpr Panel panels[] = {
        {50, -135, 26, 22, 3, 9}, {80, -20, 7, 34, 3, 5}, {100, 100, 30, 30, 15, 0.6}};
    return filled("softbox", 256, [&](const Vector& to) -> Rgb {
        double light = 0.06 + 0.05 * std::max(0.0, to[2]);
        for (const Panel& panel : panels) {
            const Vector at = direction(panel.theta * degree, panel.phi * degree);
            const Vector across{-std::sin(panel.phi * degree), std::cos(panel.phi * degree), 0};
            const Vector up{at[1] * across[2] - at[2] * across[1],
                            at[2] * across[0] - at[0] * across[2],
                            at[0] * across[1] - at[1] * across[0]};
            const double ahead = dot(to, at);
            if (ahead <= 0)
                continue;
            const auto inside = [&](const Vector& axis, double half) {
                const double off = std::atan2(std::abs(dot(to, axis)), ahead) / degree;
                return std::clamp((half - off) / panel.edge, 0.0, 1.0);
            };
            light +=
                panel.radiance * inside(across, panel.half_width) * inside(up, panel.half_height);
        }
        return {light, light, light};
    });
}

Environment even_environment() {
    return filled("white", 16, [](const Vector&) -> Rgb { return {1, 1, 1}; });
}

std::optional<Environment> environment_named(const std::string& name) {
    if (name == "none")
        return std::nullopt;
    if (name == "softbox")
        return soft_box_environment();
    if (name == "sky")
        return sky_environment();
    if (name == "white")
        return even_environment();
    if (std::filesystem::path(name).extension() != ".exr")
        throw UsageError(fmt::format("--environment {}: expected softbox, sky, white, none, or a "
                                     "latitude-longitude .exr",
                                     name));
    return read_environment(name);
}

AliasTable alias_table(const Environment& environment) {
    const std::size_t count = environment.texels.size();
    AliasTable table;
    table.own.resize(count);
    table.other.resize(count);
    table.density.resize(count);
    std::vector<double> share(count); // of a texel, times their number
    const double total = mean(environment.flux());
    std::vector<std::uint32_t> below, above;
    for (std::size_t i = 0; i < count; ++i) {
        table.density[i] = mean(environment.texels[i]) / total;
        share[i] = table.density[i] * environment.solid_angle(i / environment.width) *
                   static_cast<double>(count);
        table.other[i] = static_cast<std::uint32_t>(i);
        (share[i] < 1 ? below : above).push_back(static_cast<std::uint32_t>(i));
    }
    constexpr double whole = 4294967295.0;
    while (!below.empty() && !above.empty()) {
        const std::uint32_t low = below.back(), high = above.back();
        below.pop_back();
        table.own[low] = static_cast<std::uint32_t>(std::lround(share[low] * whole));
        table.other[low] = high;
        share[high] -= 1 - share[low];
        if (share[high] < 1) {
            above.pop_back();
            below.push_back(high);
        }
    }
    // What rounding leaves is itself.
    for (const std::vector<std::uint32_t>* rest : {&below, &above})
        for (const std::uint32_t i : *rest)
            table.own[i] = static_cast<std::uint32_t>(whole);
    return table;
}

} // namespace brdfit

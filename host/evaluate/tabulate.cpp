#include "host/evaluate/tabulate.hpp"

#include "host/error.hpp"
#include "host/evaluate/rgl.hpp"
#include "host/evaluate/synthesise.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

constexpr double steepest = 89.5 * degree; // the last theta_i: at the horizon f may be infinite
constexpr std::size_t test_pairs = 20000;
constexpr std::size_t pairs_a_pass = std::size_t{1} << 20;

/// The wavelength that a channel's name is; 0 where it is none.
float wavelength_of(const std::string& name) {
    float value = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), value);
    return error == std::errc() && end == name.data() + name.size() && value > 0 ? value : 0;
}

/// The directions of slice `slice`'s nodes, below the horizon too.
void set_nodes(const RglTables& tables, std::size_t slice, std::size_t first,
               Directions& directions) {
    const std::size_t side = tables.table.width;
    const double phi_i = tables.phi_i[slice / tables.theta_i.size()];
    const Vector wi = direction(tables.theta_i[slice % tables.theta_i.size()], phi_i);
    for (std::size_t y = 0; y < side; ++y)
        for (std::size_t x = 0; x < side; ++x) {
            const double u = static_cast<double>(x) / static_cast<double>(side - 1),
                         v = static_cast<double>(y) / static_cast<double>(side - 1);
            const Vector h =
                direction(u * u * pi / 2, (2 * v - 1) * pi + (tables.isotropic() ? phi_i : 0.0));
            const double c = wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2];
            const Vector wo{2 * c * h[0] - wi[0], 2 * c * h[1] - wi[1], 2 * c * h[2] - wi[2]};
            directions.set(first + y * side + x, wi, wo, h, c);
        }
}

/// Fills table and luminance of some slices.
void fill_slices(const BrdfFunction& brdf, const RglChannels& channels, std::size_t first,
                 std::size_t last, RglTables& tables) {
    const std::size_t side = tables.table.width, nodes = side * side;
    Directions directions((last - first) * nodes);
    for (std::size_t slice = first; slice < last; ++slice)
        set_nodes(tables, slice, (slice - first) * nodes, directions);
    const std::vector<float> f = brdf(directions);
    for (std::size_t slice = first; slice < last; ++slice)
        for (std::size_t node = 0; node < nodes; ++node) {
            const std::size_t k = (slice - first) * nodes + node;
            const double u = static_cast<double>(node % side) / static_cast<double>(side - 1);
            const double cosine = directions.above_horizon(k) ? directions.wo(k)[2] : 0;
            double mean = 0;
            for (std::size_t ch = 0; ch < channels.source.size(); ++ch) {
                const double value = cosine * f[channels.source[ch] * directions.count() + k];
                tables.table.values[(slice * channels.source.size() + ch) * nodes + node] =
                    static_cast<float>(value);
                mean += value / static_cast<double>(channels.source.size());
            }
            // d(wo) = 8 pi^2 u sin(theta_h) c du dv
            tables.luminance.values[slice * nodes + node] = static_cast<float>(
                std::max(mean, 0.0) * 8 * pi * pi * u * std::sin(u * u * pi / 2) *
                std::max<double>(directions.plane(Directions::C)[k], 0));
        }
}

/// A sampler needs a density in each slice, also where nothing is reflected.
void make_positive(std::vector<float>& luminance, std::size_t nodes) {
    for (std::size_t begin = 0; begin < luminance.size(); begin += nodes) {
        float* const slice = luminance.data() + begin;
        if (std::all_of(slice, slice + nodes, [](float x) { return x == 0; }))
            std::fill_n(slice, nodes, 1.0F);
    }
}

RglTables tabulate_at(const BrdfFunction& brdf, const RglChannels& channels, const RglSize& size,
                      const ProgressFunction& progress) {
    RglTables tables;
    tables.channels = channels.names;
    tables.wavelengths = channels.wavelengths;
    // The whole circle, whatever its symmetries: pbrt-v4 takes no part of it, and Mitsuba takes the
    // azimuth of the x axis for pi, which a half or a quarter does not reach.
    for (std::size_t p = 0; p < size.phi_i; ++p)
        tables.phi_i.push_back(
            size.phi_i == 1 ? 0.0F
                            : static_cast<float>(-pi + 2 * pi * static_cast<double>(p) /
                                                           static_cast<double>(size.phi_i - 1)));
    for (std::size_t t = 0; t < size.theta_i; ++t)
        tables.theta_i.push_back(static_cast<float>(steepest * static_cast<double>(t) /
                                                    static_cast<double>(size.theta_i - 1)));
    const std::size_t nodes = size.side * size.side, slices = tables.slices();
    tables.ndf = {2, 2, std::vector<float>(4, 1.0F)};
    tables.sigma = {2, 2, std::vector<float>(4, 0.25F)};
    tables.vndf = {2, 2, std::vector<float>(4 * slices, 1.0F)};
    tables.table = {size.side, size.side,
                    std::vector<float>(slices * channels.source.size() * nodes)};
    tables.luminance = {size.side, size.side, std::vector<float>(slices * nodes)};
    const std::size_t step = std::max<std::size_t>(1, pairs_a_pass / nodes);
    for (std::size_t first = 0; first < slices; first += step) {
        const std::size_t last = std::min(first + step, slices);
        fill_slices(brdf, channels, first, last, tables);
        tell(progress, static_cast<double>(last) / static_cast<double>(slices));
    }
    make_positive(tables.luminance.values, nodes);
    return tables;
}

/// The pairs at which tables are measured: up to 80 degrees, beyond which fits do not look either.
Directions pairs_to_test(bool isotropic) {
    const auto random = random_directions(test_pairs, isotropic, 1);
    std::vector<std::size_t> kept;
    const double least = std::cos(80 * degree);
    for (std::size_t k = 0; k < random->count(); ++k)
        if (random->wi(k)[2] > least && random->wo(k)[2] > least)
            kept.push_back(k);
    Directions pairs(kept.size());
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto [wi, wo] = random->pair(kept[i]);
        pairs.set(i, wi, wo);
    }
    return pairs;
}

/// The values of channels that a table has, in its order.
std::vector<float> selected(const std::vector<float>& values, std::size_t count,
                            const RglChannels& channels) {
    std::vector<float> made;
    made.reserve(channels.source.size() * count);
    for (const std::size_t source : channels.source) {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(source * count);
        made.insert(made.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    }
    return made;
}

std::size_t bytes_of(const RglSize& size, std::size_t channels) {
    return size.phi_i * size.theta_i * size.side * size.side * (channels + 1) * sizeof(float);
}

/// The size with one of its axes doubled.
RglSize grown(RglSize size, int axis) {
    if (axis == 0)
        size.side *= 2;
    else if (axis == 1)
        size.theta_i *= 2;
    else
        size.phi_i = 2 * size.phi_i - 1;
    return size;
}

} // namespace

RglChannels rgl_channels(const std::vector<std::string>& channels, bool spectral,
                         const std::string& source) {
    RglChannels made;
    std::vector<std::pair<float, std::size_t>> lines;
    for (std::size_t c = 0; c < channels.size(); ++c)
        lines.emplace_back(wavelength_of(channels[c]), c);
    std::sort(lines.begin(), lines.end());
    bool distinct = lines.front().first > 0;
    for (std::size_t i = 1; i < lines.size(); ++i)
        distinct = distinct && lines[i].first > lines[i - 1].first;
    if (!distinct) {
        if (channels.size() != 1 && channels.size() != 3)
            throw InputError(fmt::format("{}: {} channels; an RGL file has R, G and B, or "
                                         "channels named by wavelengths in nm",
                                         source, channels.size()));
        const std::size_t last = channels.size() - 1;
        if (!spectral)
            return {{"R", "G", "B"}, {}, {0, std::min<std::size_t>(1, last), last}};
        lines = {{465.0F, last}, {545.0F, std::min<std::size_t>(1, last)}, {620.0F, 0}};
    }
    for (const auto& [wavelength, c] : lines) {
        made.names.push_back(fmt::format("{}", wavelength));
        made.wavelengths.push_back(wavelength);
        made.source.push_back(c);
    }
    return made;
}

Tabulated tabulate(const Device& device, const BrdfFunction& brdf, const RglChannels& channels,
                   bool isotropic, std::optional<RglSize> size, const RglLimits& limits,
                   const ProgressFunction& progress) {
    const Directions pairs = pairs_to_test(isotropic);
    const std::vector<float> expected = selected(brdf(pairs), pairs.count(), channels);
    const auto made_at = [&](const RglSize& at, const ProgressFunction& told) {
        Tabulated made;
        made.size = at;
        made.tables = tabulate_at(brdf, channels, at, told);
        made.error =
            relative_error(evaluate(device, made.tables, pairs), expected, channels.source.size());
        return made;
    };
    if (size)
        return made_at(*size, progress);
    RglSize start{1, 16, 32};
    if (!isotropic)
        start = {17, 8, 32};
    // How far from good enough.
    const auto distance = [&](const Tabulated& made) {
        return std::max(made.error.median / limits.enough.median,
                        made.error.high / limits.enough.high);
    };
    Tabulated best = made_at(start, {});
    // Each round doubles the axis that helps most.
    for (int round = 1; distance(best) > 1; ++round) {
        std::optional<Tabulated> next;
        const int axes = isotropic ? 2 : 3;
        const auto begin = [&](int axis) { // the share that is done
            return 1 - std::pow(0.7, round - 1 + static_cast<double>(axis) / axes);
        };
        for (int axis = 0; axis < axes; ++axis) {
            const RglSize larger = grown(best.size, axis);
            if (bytes_of(larger, channels.source.size()) > limits.most_bytes)
                continue;
            Tabulated made = made_at(larger, part_of(progress, begin(axis), begin(axis + 1)));
            if (!next || distance(made) < distance(*next))
                next = std::move(made);
        }
        if (!next || distance(*next) > 0.97 * distance(best))
            break;
        best = std::move(*next);
    }
    return best;
}

} // namespace brdfit

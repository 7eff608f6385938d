#include "host/albedo/measured.hpp"

#include "host/albedo/nearest.hpp"
#include "host/error.hpp"
#include "host/measured/merl.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <tuple>

namespace brdfit {

namespace {

/// Independent shifts of a lattice, and the error stated in standard deviations of their estimates:
/// six standard errors of the mean.
constexpr std::size_t shifts = 16;
constexpr double stated_deviations = 1.5;
/// Points a bin of theta_h, Fibonacci numbers: the first lattice and, three numbers on each time,
/// the last.
constexpr std::size_t first_lattice = 34, last_lattice = 10946;
constexpr std::size_t average_nodes = 32;

/// Integrals over the measured part of the hemisphere: of f iz by channel, and iz / pi of what was
/// measured.
struct Integral {
    std::vector<double> values, errors;
    double measured = 0;
};

double fraction(double x) {
    return x - std::floor(x);
}

/// The integral over wi in MERL's bins for a viewer at theta, phi = 0, with `points` in each
/// theta_h. Returns the sums of each shift: channels, then what was measured.
std::vector<std::vector<double>> sum_bins(const Samples& samples, double theta, std::size_t points,
                                          std::size_t before) {
    const std::size_t channels = samples.channels.size();
    std::vector<std::vector<double>> sums(shifts, std::vector<double>(channels + 1));
    const double ox = std::sin(theta), oz = std::cos(theta);
    for (std::size_t shift = 0; shift < shifts; ++shift) {
        std::vector<double>& sum = sums[shift];
        for (int bin = 0; bin < merl::theta_h_bins; ++bin) {
            const auto edge = [](int i) {
                return std::cos(pi / 2 * i * i / (merl::theta_h_bins * merl::theta_h_bins));
            };
            const double upper = edge(bin), lower = edge(bin + 1);
            // Shifts by multiples of irrational numbers are spread evenly as well.
            const double number = static_cast<double>(shift * merl::theta_h_bins) + bin + 1;
            const double shift_u = fraction(number * 0.754877666246693),
                         shift_v = fraction(number * 0.569840290998053);
            std::vector<double> part(channels + 1);
            for (std::size_t i = 0; i < points; ++i) {
                const auto at = static_cast<double>(i), n = static_cast<double>(points);
                const double u = fraction(at / n + shift_u);
                const double v = fraction(at * static_cast<double>(before) / n + shift_v);
                const double hz = lower + (upper - lower) * u, r = std::sqrt(1 - hz * hz);
                const double hx = r * std::cos(2 * pi * v), hy = r * std::sin(2 * pi * v);
                const double c = ox * hx + oz * hz, iz = 2 * c * hz - oz;
                if (c <= 0 || iz <= 0)
                    continue;
                const std::size_t found =
                    merl::bin_of({2 * c * hx - ox, 2 * c * hy, iz}, {ox, 0, oz});
                if (!samples.valid[found])
                    continue;
                const double weight = 4 * c * iz; // iz dw_i by dw_h
                for (std::size_t ch = 0; ch < channels; ++ch)
                    part[ch] += weight * static_cast<double>(samples.channel(ch)[found]);
                part[channels] += weight / pi;
            }
            for (std::size_t k = 0; k <= channels; ++k)
                sum[k] += part[k] * 2 * pi * (upper - lower) / static_cast<double>(points);
        }
    }
    return sums;
}

Integral merl_integral(const Samples& samples, double theta, double tolerance) {
    const std::size_t channels = samples.channels.size();
    Integral integral;
    // Fibonacci lattices; three steps on, each has about four times the points.
    std::size_t before = 21, points = first_lattice;
    while (true) {
        const auto sums = sum_bins(samples, theta, points, before);
        integral = {};
        for (std::size_t k = 0; k <= channels; ++k) {
            double mean = 0, square = 0;
            for (const auto& sum : sums)
                mean += sum[k] / shifts;
            for (const auto& sum : sums)
                square += (sum[k] - mean) * (sum[k] - mean) / (shifts - 1);
            if (k == channels)
                integral.measured = std::min(mean, 1.0); // but for rounding
            else {
                integral.values.push_back(mean);
                integral.errors.push_back(stated_deviations * std::sqrt(square));
            }
        }
        if (*std::max_element(integral.errors.begin(), integral.errors.end()) <= tolerance ||
            points >= last_lattice)
            return integral;
        for (int step = 0; step < 3; ++step)
            std::tie(before, points) = std::make_pair(points, before + points);
    }
}

Albedo merl_albedo(const Samples& samples, const AlbedoGrid& grid, double tolerance,
                   const ProgressFunction& progress) {
    Albedo result;
    grid.place(result);
    const std::size_t channels = samples.channels.size(), viewers = result.count();
    // Isotropic: one azimuth tells all.
    const CosineRule fine(average_nodes), coarse(average_nodes / 2);
    std::vector<double> thetas(result.theta.begin(),
                               result.theta.begin() + static_cast<std::ptrdiff_t>(result.columns));
    for (const CosineRule* rule : {&fine, &coarse})
        for (const double mu : rule->mu)
            thetas.push_back(std::acos(mu));
    std::vector<Integral> integrals(thetas.size());
    parallel_pieces(
        thetas.size(), 1,
        [&](std::size_t k, std::size_t) {
            integrals[k] = merl_integral(samples, thetas[k], tolerance);
        },
        progress);
    std::size_t missed = 0;
    for (std::size_t k = 0; k < viewers; ++k)
        result.measured.push_back(integrals[k % result.columns].measured);
    const auto average_of = [&](const CosineRule& rule, std::size_t begin, auto quantity) {
        double sum = 0;
        for (std::size_t i = 0; i < rule.mu.size(); ++i)
            sum += rule.weight[i] * quantity(integrals[begin + i]);
        return sum;
    };
    const std::size_t begin_fine = result.columns, begin_coarse = begin_fine + average_nodes;
    for (std::size_t ch = 0; ch < channels; ++ch) {
        result.values.emplace_back();
        result.errors.emplace_back();
        for (std::size_t k = 0; k < viewers; ++k) {
            const Integral& integral = integrals[k % result.columns];
            result.values[ch].push_back(integral.values[ch]);
            result.errors[ch].push_back(integral.errors[ch]);
            missed += integral.errors[ch] > tolerance;
        }
        const auto value = [ch](const Integral& i) { return i.values[ch]; };
        const auto error = [ch](const Integral& i) { return i.errors[ch]; };
        result.average.push_back(average_of(fine, begin_fine, value));
        result.average_error.push_back(
            average_of(fine, begin_fine, error) +
            std::abs(result.average.back() - average_of(coarse, begin_coarse, value)));
    }
    result.average_measured =
        average_of(fine, begin_fine, [](const Integral& i) { return i.measured; });
    if (missed > 0)
        result.notes.push_back(
            fmt::format("{} of {} values did not reach the tolerance", missed, channels * viewers));
    result.notes.push_back(fmt::format("integral over the measured bins; tolerance {}; errors are "
                                       "of the integration, six standard errors of {} estimates",
                                       tolerance, shifts));
    return result;
}

/// Directions closer than this are the same.
constexpr double same = 1e-5;
/// Viewers a light direction needs, and points on the hemisphere of viewers.
constexpr std::size_t fewest_viewers = 8, hemisphere_points = 28657, points_before = 17711;

using Key = std::array<long long, 3>;
Key key_of(const Vector& v) {
    Key key;
    for (std::size_t a = 0; a < 3; ++a)
        key[a] = std::llround(v[a] / same);
    return key;
}

/// Samples that share one of their two directions: the others, with the mean of the values of equal
/// ones.
struct Group {
    Vector fixed{};
    std::map<Key, std::size_t> index;
    std::vector<Vector> directions;
    std::vector<std::vector<double>> sums; ///< [direction][channel]
    std::vector<double> counts;
};

/// A direction turned so that `reference` has azimuth 0, and mirrored to y >= 0.
Vector relative(const Vector& v, const Vector& reference) {
    const double r = std::hypot(reference[0], reference[1]);
    const double x = r > same ? reference[0] / r : 1, y = r > same ? reference[1] / r : 0;
    return {v[0] * x + v[1] * y, std::abs(v[1] * x - v[0] * y), v[2]};
}

std::map<Key, Group> groups_of(const Samples& samples, bool fixed_light) {
    std::map<Key, Group> groups;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        if (!samples.valid[k])
            continue;
        auto [fixed, other] = samples.directions->pair(k);
        if (!fixed_light)
            std::swap(fixed, other);
        if (samples.isotropic) {
            other = relative(other, fixed);
            fixed = {std::hypot(fixed[0], fixed[1]), 0, fixed[2]};
        }
        Group& group = groups[key_of(fixed)];
        group.fixed = fixed;
        const auto [at, is_new] = group.index.try_emplace(key_of(other), group.directions.size());
        if (is_new) {
            group.directions.push_back(other);
            group.sums.emplace_back(samples.channels.size());
            group.counts.push_back(0);
        }
        for (std::size_t ch = 0; ch < samples.channels.size(); ++ch)
            group.sums[at->second][ch] += static_cast<double>(samples.channel(ch)[k]);
        ++group.counts[at->second];
    }
    return groups;
}

Integral scattered_integral(const Group& group, bool isotropic, std::size_t channels) {
    constexpr std::size_t neighbours = 4, interpolated = 3;
    const Nearest nearest(group.directions);
    std::vector<double> reach; // squared
    for (const Vector& v : group.directions)
        reach.push_back(nearest.find(v, neighbours + 1).back().first);
    const auto value = [&](std::size_t sample, std::size_t ch) {
        return group.sums[sample][ch] / group.counts[sample];
    };
    Integral integral;
    integral.values.resize(channels);
    std::vector<double> smooth(channels);
    for (std::size_t i = 0; i < hemisphere_points; ++i) {
        const auto at = static_cast<double>(i), n = static_cast<double>(hemisphere_points);
        const double r = std::sqrt((at + 0.5) / n);
        const double phi = 2 * pi * fraction(at * static_cast<double>(points_before) / n);
        Vector v{r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r)};
        if (isotropic)
            v[1] = std::abs(v[1]);
        const auto found = nearest.find(v, interpolated);
        if (found[0].first > reach[found[0].second])
            continue;
        integral.measured += 1 / n;
        std::array<double, interpolated> weight{};
        double total = 0;
        for (std::size_t k = 0; k < found.size(); ++k)
            total += weight[k] = 1 / (found[k].first + 1e-12);
        for (std::size_t ch = 0; ch < channels; ++ch) {
            integral.values[ch] += pi / n * value(found[0].second, ch);
            for (std::size_t k = 0; k < found.size(); ++k)
                smooth[ch] += pi / n * weight[k] / total * value(found[k].second, ch);
        }
    }
    for (std::size_t ch = 0; ch < channels; ++ch)
        integral.errors.push_back(std::abs(integral.values[ch] - smooth[ch]));
    return integral;
}

/// Integral over sin^2 theta between the rows of a quantity given at each, averaged over rows of
/// the same theta.
template <typename Quantity>
double over_rows(const std::vector<const Group*>& rows, Quantity quantity) {
    std::map<long long, std::pair<double, double>> by_height; // sum, count
    std::map<long long, double> height;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const double s = 1 - rows[k]->fixed[2] * rows[k]->fixed[2];
        const long long key = std::llround(s / same);
        by_height[key].first += quantity(k);
        by_height[key].second += 1;
        height[key] = s;
    }
    double sum = 0, s_before = 0, value_before = 0;
    bool first = true;
    for (const auto& [key, mean] : by_height) {
        const double s = height[key], value = mean.first / mean.second;
        if (!first)
            sum += (s - s_before) * (value + value_before) / 2;
        first = false;
        s_before = s;
        value_before = value;
    }
    return sum;
}

Albedo scattered_albedo(const Samples& samples, const ProgressFunction& progress) {
    const std::map<Key, Group> by_light = groups_of(samples, true),
                               by_viewer = groups_of(samples, false);
    const bool fixed_light = by_light.size() <= by_viewer.size();
    const std::size_t channels = samples.channels.size();
    std::vector<const Group*> rows;
    std::size_t dropped = 0;
    for (const auto& [key, group] : fixed_light ? by_light : by_viewer) {
        const bool enough = group.directions.size() >= fewest_viewers;
        dropped += !enough;
        if (enough)
            rows.push_back(&group);
    }
    if (rows.empty())
        throw InputError(fmt::format(
            "{}: no {} direction was measured with {} or more {} directions; the albedo of "
            "scattered samples needs them",
            samples.source, fixed_light ? "light" : "viewer", fewest_viewers,
            fixed_light ? "viewer" : "light"));
    std::sort(rows.begin(), rows.end(), [](const Group* a, const Group* b) {
        return std::make_pair(-a->fixed[2], std::atan2(a->fixed[1], a->fixed[0])) <
               std::make_pair(-b->fixed[2], std::atan2(b->fixed[1], b->fixed[0]));
    });
    std::vector<Integral> integrals(rows.size());
    parallel_pieces(
        rows.size(), 1,
        [&](std::size_t k, std::size_t) {
            integrals[k] = scattered_integral(*rows[k], samples.isotropic, channels);
        },
        progress);
    Albedo result;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const Vector& v = rows[k]->fixed;
        const double phi = std::hypot(v[0], v[1]) > same ? std::atan2(v[1], v[0]) : 0;
        result.theta.push_back(std::atan2(std::hypot(v[0], v[1]), v[2]));
        result.phi.push_back(phi < 0 ? phi + 2 * pi : phi);
        result.measured.push_back(integrals[k].measured);
    }
    for (std::size_t ch = 0; ch < channels; ++ch) {
        result.values.emplace_back();
        result.errors.emplace_back();
        for (const Integral& integral : integrals) {
            result.values[ch].push_back(integral.values[ch]);
            result.errors[ch].push_back(integral.errors[ch]);
        }
        result.average.push_back(
            over_rows(rows, [&](std::size_t k) { return integrals[k].values[ch]; }));
        result.average_error.push_back(
            over_rows(rows, [&](std::size_t k) { return integrals[k].errors[ch]; }));
    }
    result.average_measured = over_rows(rows, [&](std::size_t k) { return integrals[k].measured; });
    result.notes.push_back(fmt::format(
        "each row is one {0} direction of the file, integrated over {1} directions, each taking "
        "the "
        "nearest measured value as far as that sample's fourth nearest neighbour; errors are the "
        "difference from an interpolation",
        fixed_light ? "light" : "viewer", fixed_light ? "viewer" : "light"));
    if (dropped > 0)
        result.notes.push_back(fmt::format("{} {} directions with fewer than {} samples left out",
                                           dropped, fixed_light ? "light" : "viewer",
                                           fewest_viewers));
    return result;
}

} // namespace

bool on_grid(const Samples& samples) {
    return samples.directions == merl::bin_directions();
}

Albedo measured_albedo(const Samples& samples, const AlbedoGrid& grid, double tolerance,
                       const ProgressFunction& progress) {
    require_tolerance(tolerance);
    Albedo result = on_grid(samples) ? merl_albedo(samples, grid, tolerance, progress)
                                     : scattered_albedo(samples, progress);
    result.channels = samples.channels;
    return result;
}

} // namespace brdfit

#include "host/evaluate/synthesise.hpp"

#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/measured/merl.hpp"
#include "host/parallel.hpp"

#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

// A well-mixed 64-bit word for each (seed, counter): SplitMix64's finaliser (Steele et al. 2014).
std::uint64_t mixed(std::uint64_t seed, std::uint64_t counter) {
    std::uint64_t z = seed * 0xD1342543DE82EF95ULL + (counter + 1) * 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
}

// Uniform in (0, 1).
double uniform(std::uint64_t seed, std::uint64_t counter) {
    return (static_cast<double>(mixed(seed, counter) >> 11) + 0.5) * 0x1p-53;
}

// A normal deviate by Box and Muller; counters 2 k and 2 k + 1.
double normal(std::uint64_t seed, std::uint64_t k) {
    return std::sqrt(-2 * std::log(uniform(seed, 2 * k))) *
           std::cos(2 * pi * uniform(seed, 2 * k + 1));
}

bool same_azimuth(const Directions& directions) {
    for (std::size_t k = 0; k < directions.count(); ++k) {
        const Vector wi = directions.wi(k);
        if (std::abs(wi[1]) > 1e-6 || wi[0] < -1e-6)
            return false;
    }
    return true;
}

} // namespace

std::shared_ptr<const Directions> random_directions(std::size_t count, bool isotropic,
                                                    std::uint64_t seed) {
    auto directions = std::make_shared<Directions>(count);
    std::uint64_t counter = 0;
    const auto next = [&] { return uniform(seed, counter++); };
    for (std::size_t k = 0; k < count; ++k) {
        Vector wi{}, wo{};
        do {
            if (k % 2 == 0) {
                wi = direction(std::acos(next()), 2 * pi * next());
                wo = direction(std::acos(next()), 2 * pi * next());
            } else {
                const Vector h = direction(1e-3 * std::pow(1e3, next()), 2 * pi * next());
                wi = direction(std::acos(next()), 2 * pi * next());
                const double c = h[0] * wi[0] + h[1] * wi[1] + h[2] * wi[2];
                for (std::size_t i = 0; i < 3; ++i)
                    wo[i] = 2 * c * h[i] - wi[i];
            }
        } while (!(wi[2] > 1e-3) || !(wo[2] > 1e-3));
        if (isotropic) {
            const double phi_i = std::atan2(wi[1], wi[0]), phi_o = std::atan2(wo[1], wo[0]);
            wi = direction(std::atan2(std::hypot(wi[0], wi[1]), wi[2]), 0);
            wo = direction(std::atan2(std::hypot(wo[0], wo[1]), wo[2]), phi_o - phi_i);
        }
        directions->set(k, wi, wo);
    }
    return directions;
}

Samples synthesise(const Device& device, const Material& material,
                   std::shared_ptr<const Directions> directions, double noise, std::uint64_t seed) {
    Samples samples;
    samples.format = "synthesised";
    samples.channels = material.channels;
    samples.values = evaluate(device, material, *directions);
    samples.isotropic = material.isotropic() && same_azimuth(*directions);
    samples.valid.resize(directions->count());
    for (std::size_t k = 0; k < directions->count(); ++k)
        samples.valid[k] = directions->above_horizon(k) ? 1 : 0;
    samples.directions = std::move(directions);
    if (noise > 0)
        parallel_pieces(samples.values.size(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                samples.values[i] =
                    static_cast<float>(samples.values[i] * (1 + noise * normal(seed, i)));
        });
    return samples;
}

Samples synthesise_merl(const Device& device, const Material& material, double noise,
                        std::uint64_t seed, const std::string& source) {
    if (!material.isotropic())
        throw InputError(fmt::format(
            "{}: the material is anisotropic; MERL's layout holds isotropic materials only",
            source));
    Samples samples = synthesise(device, material, merl::bin_directions(), noise, seed);
    samples.isotropic = true;
    samples.weights = merl::bin_weights();
    return samples;
}

} // namespace brdfit

#include "tests/support/pairs.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

namespace brdfit::test {

double uniform(Random& random, double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(random);
}

Vector at_height(double z, double phi) {
    const double r = std::sqrt((1 - z) * (1 + z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}

Vector at_tangent(double tangent, double phi) {
    const double z = 1 / std::sqrt(1 + tangent * tangent);
    return {tangent * z * std::cos(phi), tangent * z * std::sin(phi), z};
}

Vector mirrored(const Vector& w, const Vector& h) {
    const double c = w[0] * h[0] + w[1] * h[1] + w[2] * h[2];
    return {2 * c * h[0] - w[0], 2 * c * h[1] - w[1], 2 * c * h[2] - w[2]};
}

Pair random_pair(Random& random) {
    return {at_height(1 - uniform(random), uniform(random, 0, 2 * pi)),
            at_height(1 - uniform(random), uniform(random, 0, 2 * pi))};
}

Pair extreme_pair(Random& random, std::size_t kind) {
    const auto azimuth = [&] { return uniform(random, 0, 2 * pi); };
    const auto grazing = [&] { return at_height(std::pow(10, uniform(random, -7, 0)), azimuth()); };
    switch (kind % 5) {
    case 1:
        return {grazing(), grazing()};
    case 2: {
        const Vector wi = grazing();
        const Vector wo = mirrored(wi, at_tangent(std::pow(10, uniform(random, -7, 0)), azimuth()));
        return {wi, wo[2] > 0 ? wo : Vector{-wi[0], -wi[1], wi[2]}};
    }
    case 3: {
        const Vector wi = grazing();
        const double z = std::pow(10, uniform(random, -7, 0));
        return {wi, at_height(z, std::atan2(-wi[1], -wi[0]))};
    }
    case 4: {
        const Vector wi = grazing();
        return {wi, wi};
    }
    default:
        return random_pair(random);
    }
}

std::vector<Pair> special_pairs() {
    std::vector<Pair> pairs;
    const std::vector<double> heights = {1, 0.999999, 0.8, 0.5, 0.1, 0.01, 1e-4, 1e-7};
    for (const double iz : heights)
        for (const double oz : heights)
            for (const double phi : {0.0, 1e-6, 0.3, pi / 2, 2.0, pi - 1e-6}) {
                const Vector wi = at_height(iz, 0.7), wo = at_height(oz, 0.7 + phi);
                pairs.push_back({wi, wo});
                if (phi == 0)
                    pairs.push_back({wi, {-wo[0], -wo[1], wo[2]}});
            }
    return pairs;
}

std::vector<Pair> chosen_pairs() {
    Random random(1);
    std::vector<Pair> pairs = special_pairs();
    for (int i = 0; i < 200; ++i)
        pairs.push_back(random_pair(random));
    while (pairs.size() < 1200) {
        const Vector wi = random_pair(random).wi;
        const Vector h =
            at_tangent(std::pow(10, uniform(random, -5, 1)), uniform(random, 0, 2 * pi));
        const Vector wo = mirrored(wi, h);
        if (wo[2] > 0)
            pairs.push_back({wi, wo});
    }
    for (int i = 0; i < 200; ++i)
        pairs.push_back(
            {at_height(std::pow(10, uniform(random, -7, -1)), uniform(random, 0, 2 * pi)),
             at_height(std::pow(10, uniform(random, -7, 0)), uniform(random, 0, 2 * pi))});
    return pairs;
}

Directions directions_of(const std::vector<Pair>& pairs) {
    Directions directions(pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k)
        directions.set(k, pairs[k].wi, pairs[k].wo);
    return directions;
}

double relative_tolerance(double value) {
    return 5e-5 + 2e-6 * std::abs(std::log(std::max(value, tiny)));
}

void Mismatches::check(bool good, const std::string& what, const Pair& pair, double value,
                       double reference, double tolerance) {
    if (good)
        return;
    if (++count_ <= 5)
        text_ += fmt::format("{} at wi ({:.9g}) wo ({:.9g}): {:.9g}; expected {:.9g} +- {:.2g}\n",
                             what, fmt::join(pair.wi, ", "), fmt::join(pair.wo, ", "), value,
                             reference, tolerance);
}

Mismatches::~Mismatches() {
    EXPECT_EQ(count_, 0) << text_;
}

} // namespace brdfit::test

#include "tests/support/albedo_reference.hpp"

#include "host/quadrature.hpp"
#include "tests/support/reference_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace brdfit::test {

namespace {

const Quadrature rule = gauss_legendre(8);

/// Calls body(x, weight) at the points of a rule on the panels between consecutive breaks.
template <typename Body>
void over_panels(std::vector<double> breaks, Body body) {
    std::sort(breaks.begin(), breaks.end());
    for (std::size_t i = 1; i < breaks.size(); ++i) {
        const double width = breaks[i] - breaks[i - 1];
        if (width <= 0)
            continue;
        for (std::size_t k = 0; k < rule.size(); ++k)
            body(breaks[i - 1] + width * rule.x[k], width * rule.w[k]);
    }
}

/// Breaks of the azimuth: quarters, and closer and closer to where the plane of wo is left.
std::vector<double> azimuths(double narrow) {
    std::vector<double> breaks;
    for (int quarter = 0; quarter <= 4; ++quarter) {
        const double at = quarter * pi / 2;
        breaks.push_back(at);
        for (double d = pi / 4; d > narrow / 4 && d > 1e-9; d /= 2)
            for (const double x : {at - d, at + d})
                if (x > 0 && x < 2 * pi)
                    breaks.push_back(x);
    }
    return breaks;
}

/// Adds the r below the last break at which iz = oz, or one of Cook and Torrance's 2 hz oz = c and
/// 2 hz iz = c holds, on the azimuth where ox cos(phi) = x.
void add_kinks(double x, double oz, std::vector<double>& breaks) {
    const std::array<std::function<double(double)>, 3> signs = {
        [=](double r) { return x * r + oz - oz * (1 + r * r); },
        [=](double r) { return x * r - oz; },
        [=](double r) { return (x * r + oz) * (3 - r * r) - 2 * oz * (1 + r * r); },
    };
    std::sort(breaks.begin(), breaks.end());
    const std::vector<double> old = breaks;
    for (const auto& sign : signs)
        for (std::size_t i = 1; i < old.size(); ++i) {
            double lower = old[i - 1], upper = old[i];
            if ((sign(lower) > 0) == (sign(upper) > 0))
                continue;
            for (int k = 0; k < 50; ++k) {
                const double middle = (lower + upper) / 2;
                ((sign(lower) > 0) == (sign(middle) > 0) ? lower : upper) = middle;
            }
            breaks.push_back(lower);
        }
}

/// Calls body(p, q, weight) over the half vector's slopes (p, q) for which wi is above the horizon;
/// weight is the solid angle of wi. The viewer is (ox, 0, oz).
template <typename Body>
void over_slopes(double ox, double oz, double scale, bool kinks, Body body) {
    over_panels(azimuths(std::min(oz, scale)), [&](double phi, double phi_weight) {
        const double x = ox * std::cos(phi);
        // iz = 2 (ox p + oz) / (1 + r^2) - oz is positive below this r.
        const double end = x > 0 ? (x + std::hypot(x, oz)) / oz : oz / (std::hypot(x, oz) - x);
        std::vector<double> breaks{0, end};
        for (double r = scale / 16; r < end; r *= 2)
            breaks.push_back(r);
        for (double d = end / 2; d > 1e-9 * end; d /= d > 1e-3 * end ? 2 : 8)
            breaks.push_back(end - d);
        if (kinks)
            add_kinks(x, oz, breaks);
        over_panels(breaks, [&](double r, double r_weight) {
            const double p = r * std::cos(phi), q = r * std::sin(phi), s2 = 1 + r * r;
            // dw_h = r dr dphi / s^3, dw_i = 4 c dw_h, c = (ox p + oz) / s
            body(p, q, 4 * (ox * p + oz) / (s2 * s2) * r * r_weight * phi_weight);
        });
    });
}

} // namespace

double hemisphere_integral(const std::function<double(const Vector& wi)>& f, const Vector& wo,
                           double scale, bool kinks) {
    const double ox = std::hypot(wo[0], wo[1]), oz = wo[2];
    const double cosine = ox > 0 ? wo[0] / ox : 1, sine = ox > 0 ? wo[1] / ox : 0;
    double sum = 0;
    over_slopes(ox, oz, scale, kinks, [&](double p, double q, double weight) {
        const double s2 = 1 + p * p + q * q, twice = 2 * (ox * p + oz) / s2; // 2 c / s
        const double x = twice * p - ox, y = twice * q, z = twice - oz;
        if (z > 0)
            sum += f({x * cosine - y * sine, x * sine + y * cosine, z}) * weight;
    });
    return sum;
}

double reference_albedo(const std::string& model, bool isotropic, const std::vector<double>& theta,
                        const Vector& wo, double scale) {
    return hemisphere_integral(
        [&](const Vector& wi) { return reference_value(model, isotropic, theta, wi, wo) * wi[2]; },
        wo, scale, true);
}

namespace {

double fresnel(double c, double ior) {
    const double sine2 = (1 - c * c) / (ior * ior);
    if (sine2 >= 1)
        return 1;
    const double t = std::sqrt(1 - sine2);
    const double s = (c - ior * t) / (c + ior * t), p = (ior * c - t) / (ior * c + t);
    return (s * s + p * p) / 2;
}

} // namespace

GgxAlbedo ggx_albedo(double mu, double alpha, double ior) {
    const double ox = std::sqrt(1 - mu * mu);
    const auto weight_of = [&](double c) { return ior > 0 ? fresnel(c, ior) : std::pow(1 - c, 5); };
    if (alpha < 1e-6)
        return {1, weight_of(mu)};
    const auto smith = [&](double z) { // Lambda
        const double tan2 = (1 - z * z) / (z * z);
        return (std::sqrt(1 + alpha * alpha * tan2) - 1) / 2;
    };
    GgxAlbedo albedo{0, 0};
    const double lambda_o = smith(mu);
    // g iz at light directions of height iz with the half vector's slopes squared r2 and c.
    const auto add = [&](double iz, double r2, double c, double weight) {
        // D = s^4 / (pi alpha^2 (1 + r^2 / alpha^2)^2)
        const double s2 = 1 + r2, e = 1 + r2 / (alpha * alpha);
        const double d = s2 * s2 / (pi * alpha * alpha * e * e);
        const double value = d / (1 + smith(iz) + lambda_o) / (4 * mu) * weight;
        albedo.all += value;
        albedo.weighted += value * weight_of(c);
    };
    if (ior > 0 && ior < 1) {
        constexpr int heights = 1500, azimuths = 750;
        for (int i = 0; i < heights; ++i)
            for (int j = 0; j < azimuths; ++j) {
                const double u = (i + 0.5) / heights, iz = u * u, r = std::sqrt(1 - iz * iz);
                const double phi = pi * (j + 0.5) / azimuths;
                const double x = ox + r * std::cos(phi), y = r * std::sin(phi), z = mu + iz;
                add(iz, (x * x + y * y) / (z * z), std::sqrt(x * x + y * y + z * z) / 2,
                    2 * u / heights * 2 * pi / azimuths);
            }
        return albedo;
    }
    over_slopes(ox, mu, alpha, false, [&](double p, double q, double weight) {
        const double r2 = p * p + q * q;
        const double iz = std::min(1.0, 2 * (ox * p + mu) / (1 + r2) - mu);
        if (iz > 0)
            add(iz, r2, (ox * p + mu) / std::sqrt(1 + r2), weight);
    });
    return albedo;
}

double average_over_cosine(const std::function<double(double mu)>& f) {
    std::vector<double> breaks{0, 1};
    for (double mu = 0.5; mu > 1e-4; mu /= 2)
        breaks.push_back(mu);
    double sum = 0;
    over_panels(breaks, [&](double mu, double weight) { sum += 2 * mu * f(mu) * weight; });
    return sum;
}

} // namespace brdfit::test

#include "tests/support/reference_microfacet.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit::test {

namespace {

/// Nodes and weights of the double exponential rule over (-1, 1) (Takahasi and Mori 1974).
struct Rule {
    std::vector<double> x, w;
    explicit Rule(double step) {
        for (double t = -3.2; t <= 3.2 + 1e-9; t += step) {
            const double s = pi / 2 * std::sinh(t), c = std::cosh(s);
            x.push_back(std::tanh(s));
            w.push_back(step * pi / 2 * std::cosh(t) / (c * c));
        }
    }
};

template <typename F>
double integrate(double from, double to, const F& f) {
    static const Rule rule(0.16);
    double sum = 0;
    for (std::size_t i = 0; i < rule.x.size(); ++i)
        sum += rule.w[i] * f(0.5 * (from + to) + 0.5 * (to - from) * rule.x[i]);
    return 0.5 * (to - from) * sum;
}

/// Over the pieces of [from, to] that the ends make.
template <typename F>
double integrate_pieces(double from, double to, const std::vector<double>& ends, const F& f) {
    double sum = 0, begin = from;
    for (const double end : ends)
        if (end > begin && end < to) {
            sum += integrate(begin, end, f);
            begin = end;
        }
    return to > begin ? sum + integrate(begin, to, f) : sum;
}

std::vector<double> sorted(std::vector<double> ends) {
    std::sort(ends.begin(), ends.end());
    return ends;
}

} // namespace

ReferenceDistribution reference_gaussian(double sigma_x, double sigma_y, double tilt) {
    ReferenceDistribution result;
    result.p = [=](const Vector& h) {
        const double x = std::cos(tilt) * h[0] - std::sin(tilt) * h[2];
        const double z = std::sin(tilt) * h[0] + std::cos(tilt) * h[2];
        if (z <= 0)
            return 0.0;
        return std::exp(-std::pow(x / z / sigma_x, 2) - std::pow(h[1] / z / sigma_y, 2));
    };
    for (const double s : {-6.0, -3.0, -1.0, 0.0, 1.0, 3.0, 6.0}) {
        result.a_ends.push_back(tilt + std::atan(s * sigma_x));
        result.b_ends.push_back(std::isinf(sigma_y) ? 0 : std::atan(s * sigma_y));
    }
    for (const double horizon : {tilt - pi / 2, tilt + pi / 2})
        result.a_ends.push_back(horizon > pi ? horizon - 2 * pi : horizon);
    result.a_ends = sorted(result.a_ends);
    result.b_ends = sorted(result.b_ends);
    return result;
}

ReferenceDistribution reference_velvet(double sigma) {
    return {[=](const Vector& h) {
                const double sine2 = h[0] * h[0] + h[1] * h[1];
                return h[2] <= 0 || sine2 == 0 ? 0 : std::exp(-h[2] * h[2] / sine2 / sigma / sigma);
            },
            {-pi / 2, 0, pi / 2},
            {0}};
}

ReferenceDistribution reference_sum(double weight_1, const ReferenceDistribution& one,
                                    double weight_2, const ReferenceDistribution& two) {
    ReferenceDistribution result = one;
    result.p = [=](const Vector& h) { return weight_1 * one.p(h) + weight_2 * two.p(h); };
    result.a_ends.insert(result.a_ends.end(), two.a_ends.begin(), two.a_ends.end());
    result.b_ends.insert(result.b_ends.end(), two.b_ends.begin(), two.b_ends.end());
    result.a_ends = sorted(result.a_ends);
    result.b_ends = sorted(result.b_ends);
    return result;
}

double integrate_facing(const ReferenceDistribution& distribution, const Vector& k,
                        const std::function<double(const Vector& h)>& weight) {
    // h.k = cos b A(a) + sin b k.y changes its sign once over b, at tan b = -A / k.y.
    std::vector<double> a_ends = distribution.a_ends;
    a_ends.push_back(std::atan2(-k[2], k[0])); // where A does
    a_ends.push_back(std::atan2(k[2], -k[0]));
    return integrate_pieces(-pi, pi, sorted(a_ends), [&](double a) {
        const double facing = k[0] * std::sin(a) + k[2] * std::cos(a);
        double from = -pi / 2, to = pi / 2;
        if (k[1] > 0)
            from = std::atan2(-facing, k[1]);
        else if (k[1] < 0)
            to = std::atan2(facing, -k[1]);
        else if (facing <= 0)
            return 0.0;
        return integrate_pieces(from, to, distribution.b_ends, [&](double b) {
            const Vector h = {std::cos(b) * std::sin(a), std::sin(b), std::cos(b) * std::cos(a)};
            const double p = distribution.p(h);
            return p == 0 ? 0 : std::cos(b) * p * weight(h);
        });
    });
}

double reference_area(const ReferenceDistribution& distribution, const Vector& k) {
    return integrate_facing(distribution, k, [&](const Vector& h) {
        return std::max(0.0, h[0] * k[0] + h[1] * k[1] + h[2] * k[2]);
    });
}

double integrate_sphere(const ReferenceDistribution& distribution,
                        const std::function<double(const Vector& h)>& weight) {
    return integrate_pieces(-pi, pi, distribution.a_ends, [&](double a) {
        return integrate_pieces(-pi / 2, pi / 2, distribution.b_ends, [&](double b) {
            const Vector h = {std::cos(b) * std::sin(a), std::sin(b), std::cos(b) * std::cos(a)};
            const double p = distribution.p(h);
            return p == 0 ? 0 : std::cos(b) * p * weight(h);
        });
    });
}

} // namespace brdfit::test

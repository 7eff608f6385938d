#include "host/quadrature.hpp"

#include "host/directions.hpp"

#include <cmath>

namespace brdfit {

Quadrature gauss_legendre(std::size_t n) {
    Quadrature q;
    q.x.resize(n);
    q.w.resize(n);
    const auto count = static_cast<double>(n);
    for (std::size_t i = 0; i < n; ++i) {
        double x = std::cos(pi * (static_cast<double>(i) + 0.75) / (count + 0.5)), slope = 1;
        for (int step = 0; step < 20; ++step) { // Newton on the Legendre polynomial
            double before = 0, p = 1;
            for (std::size_t k = 1; k <= n; ++k) {
                const auto order = static_cast<double>(k);
                const double next = ((2 * order - 1) * x * p - (order - 1) * before) / order;
                before = p;
                p = next;
            }
            slope = count * (x * p - before) / (x * x - 1);
            const double change = p / slope;
            x -= change;
            if (std::abs(change) < 1e-15)
                break;
        }
        q.x[n - 1 - i] = 0.5 * (1 + x);
        q.w[n - 1 - i] = 1 / ((1 - x * x) * slope * slope);
    }
    return q;
}

Quadrature gauss_legendre(const std::vector<double>& ends, std::size_t n) {
    const Quadrature one = gauss_legendre(n);
    Quadrature q;
    for (std::size_t i = 0; i + 1 < ends.size(); ++i)
        for (std::size_t k = 0; k < n; ++k) {
            q.x.push_back(ends[i] + (ends[i + 1] - ends[i]) * one.x[k]);
            q.w.push_back((ends[i + 1] - ends[i]) * one.w[k]);
        }
    return q;
}

} // namespace brdfit

// The rule that tables, averages and the tests' own references are integrated by.

#include "host/quadrature.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace brdfit {

namespace {

double of_power(const Quadrature& rule, double power) {
    double sum = 0;
    for (std::size_t i = 0; i < rule.size(); ++i)
        sum += rule.w[i] * std::pow(rule.x[i], power);
    return sum;
}

TEST(GaussLegendre, is_exact_for_polynomials_below_twice_its_nodes) {
    for (const std::size_t n : {1U, 2U, 3U, 8U, 24U, 128U, 512U}) {
        const Quadrature rule = gauss_legendre(n);
        ASSERT_EQ(rule.size(), n);
        for (std::size_t i = 0; i < n; ++i) {
            EXPECT_GT(rule.w[i], 0);
            EXPECT_GT(rule.x[i], i == 0 ? 0 : rule.x[i - 1]);
        }
        EXPECT_LT(rule.x.back(), 1);
        for (std::size_t power = 0; power < 2 * n; ++power)
            EXPECT_NEAR(of_power(rule, static_cast<double>(power)),
                        1 / static_cast<double>(power + 1), 1e-14)
                << n << " nodes";
    }
    EXPECT_GT(std::abs(of_power(gauss_legendre(3), 6) - 1.0 / 7), 1e-4);
}

TEST(GaussLegendre, goes_between_each_two_ends) {
    const Quadrature rule = gauss_legendre({-1, 0, 0.5, 2}, 2);
    ASSERT_EQ(rule.size(), 6U);
    EXPECT_NEAR(of_power(rule, 0), 3, 1e-15);
    EXPECT_NEAR(of_power(rule, 3), (16 - 1) / 4.0, 1e-14);
    EXPECT_GT(rule.x[0], -1);
    EXPECT_LT(rule.x[1], 0);
    EXPECT_LT(rule.x[3], 0.5);
}

} // namespace

} // namespace brdfit

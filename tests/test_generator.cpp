// The microfacet generator's tables against float64 integrals, and the known answers of the paper.

#include "host/error.hpp"
#include "host/table/generator.hpp"
#include "tests/fits.hpp"
#include "tests/reference_microfacet.hpp"
#include "tests/support.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>

namespace brdfit::test {

namespace {

constexpr double pi = 3.14159265358979323846, degree = pi / 180;
constexpr double infinity = std::numeric_limits<double>::infinity();

const Generator& generator() {
    static const Generator one(device());
    return one;
}

Distribution distribution_of(const std::string& spec) {
    return parse_distribution(spec, "spec.json",
                              [](const DistributionPart& part) { return generator().mass(part); });
}

MicrofacetTable table_of(const std::string& spec, std::size_t points = 200) {
    return generator().generate(distribution_of(spec), {points, false}, "spec.json");
}

struct Known {
    std::string spec;
    ReferenceDistribution reference;
};

std::vector<Known> known() {
    const auto normalised = [](double sigma) {
        const ReferenceDistribution d = reference_gaussian(sigma, infinity);
        return 1 / integrate_sphere(d, [](const Vector&) { return 1.0; });
    };
    return {
        {R"({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.2})",
         reference_gaussian(0.1, 0.2)},
        {R"({"distribution": "gaussian", "sigma": 1})", reference_gaussian(1, 1)},
        {R"({"distribution": "gaussian", "sigma": 0.01})", reference_gaussian(0.01, 0.01)},
        {R"({"distribution": "gaussian", "sigma_x": 0.01, "sigma_y": null})",
         reference_gaussian(0.01, infinity)},
        {R"({"distribution": "gaussian", "sigma_x": 3, "sigma_y": 0.02})",
         reference_gaussian(3, 0.02)},
        {R"({"distribution": "grooves"})",
         reference_sum(1, reference_gaussian(0.1, 0.1, 40 * degree), 1,
                       reference_gaussian(0.1, 0.1, -40 * degree))},
        {R"({"distribution": "satin"})",
         reference_sum(0.7 * normalised(0.1), reference_gaussian(0.1, infinity),
                       0.3 * normalised(0.3), reference_gaussian(0.3, infinity))},
        {R"({"distribution": "velvet"})", reference_velvet(0.5)},
        {R"({"distribution": "slanted-velvet"})", reference_gaussian(0.5, infinity, 50 * degree)},
    };
}

} // namespace

TEST(Generator, finds_visible_areas_within_1e_5) {
    for (const Known& one : known()) {
        SCOPED_TRACE(one.spec);
        const MicrofacetTable table = table_of(one.spec);
        const Grid& grid = table.grid;
        const double height = integrate_sphere(one.reference, [](const Vector& h) { return h[2]; });
        EXPECT_NEAR(table.mean[2], height, 1e-5 * height);
        double worst = 0;
        for (std::size_t r = 0; r < grid.rows; r += grid.columns == 1 ? 13 : 1)
            for (std::size_t k = 0; k < grid.columns; k += 3) {
                const Vector d = grid.direction(static_cast<double>(r), static_cast<double>(k));
                const double expected = reference_area(one.reference, d);
                const double g = table.g[r * grid.columns + k];
                worst = std::max(worst, std::abs(g / expected - 1));
                EXPECT_NEAR(g, expected, 1e-5 * expected)
                    << r << " " << k << " " << d[0] << " " << d[1] << " " << d[2];
            }
        fmt::print("{}: worst {:.2g}\n", one.spec, worst);
    }
}

TEST(Generator, finds_reflectances_within_1e_4) {
    for (const Known& one : known()) {
        SCOPED_TRACE(one.spec);
        const MicrofacetTable table = table_of(one.spec, 50);
        const MicrofacetTable finer =
            generator().generate(distribution_of(one.spec), {50, false, 2}, "spec.json");
        double worst = 0, most = 0;
        for (const bool correlated : {false, true})
            for (const int f0 : {0, 1})
                for (std::size_t i = 0; i < table.g.size(); ++i) {
                    const double r = table.reflectance(f0, correlated)[i];
                    const double expected = finer.reflectance(f0, correlated)[i];
                    EXPECT_NEAR(r, expected, 1e-4) << f0 << correlated << i;
                    if (std::abs(r - expected) > 3e-4)
                        fmt::print("f0 {} corr {} row {} col {}: {} {}  e {} phi {}\n", f0,
                                   correlated, i / table.grid.columns, i % table.grid.columns, r,
                                   expected,
                                   table.grid.elevation(double(i / table.grid.columns)) / degree,
                                   table.grid.azimuth(double(i % table.grid.columns)) / degree);
                    worst = std::max(worst, std::abs(r - expected));
                    most = std::max(most, r);
                }
        fmt::print("{}: worst {:.2g} most {:.6f}\n", one.spec, worst, most);
    }
}

} // namespace brdfit::test

// brdfit plot: what its pictures show, by numbers, and what it refuses.

#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/lines.hpp"
#include "host/image/image.hpp"
#include "tests/support/cli.hpp"

#include <cmath>
#include <fmt/format.h>
#include <regex>

namespace brdfit {

namespace {

using namespace test;

struct Point {
    double x, y;
};

class Plots : public Cli {
  protected:
    std::string in(const std::string& name) const { return folder / name; }
    Outcome plot(const std::string& out, std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), "plot");
        arguments.insert(arguments.end(), {"-o", in(out)});
        return run_program(arguments);
    }
    std::string svg(const std::vector<std::string>& arguments) const {
        const Outcome outcome = plot("plot.svg", arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return read_file(in("plot.svg"));
    }
};

/// The points of a curve's path, by its number among the curves.
std::vector<Point> points_of(const std::string& svg, int curve) {
    std::smatch found;
    const std::regex path(
        fmt::format("class=\"c{}\" stroke-width=\"1.5\" d=\"(M[^\"]*L[^\"]*)\"", curve));
    std::vector<Point> points;
    if (!std::regex_search(svg, found, path))
        return points;
    const std::string text = found[1];
    const std::regex pair("[ML]([-0-9.]+) ([-0-9.]+)");
    for (auto at = std::sregex_iterator(text.begin(), text.end(), pair);
         at != std::sregex_iterator(); ++at)
        points.push_back({std::stod((*at)[1]), std::stod((*at)[2])});
    return points;
}

/// Where the curve is at x, between its points.
double at(const std::vector<Point>& points, double x) {
    for (std::size_t k = 1; k < points.size(); ++k)
        if (points[k].x >= x)
            return points[k - 1].y + (points[k].y - points[k - 1].y) * (x - points[k - 1].x) /
                                         (points[k].x - points[k - 1].x);
    return std::nan("");
}

/// Pictures of plots: 90 degrees over 400, from x 64; a middle at (264, 268).
constexpr double left = 64, middle = 264, below = 268;

double value_at(const Device& device, const Material& material, const Vector& wi,
                const Vector& wo) {
    Directions directions(1);
    directions.set(0, wi, wo);
    double sum = 0;
    for (const float f : evaluate(device, material, directions))
        sum += static_cast<double>(f) / static_cast<double>(material.channels.size());
    return sum;
}

TEST_F(Plots, polar_radii_are_cube_roots_of_values) {
    const std::string picture = svg({in("paint.json"), "--theta", "30"});
    const std::vector<Point> points = points_of(picture, 0);
    ASSERT_GT(points.size(), 50U);
    const Material material = read_material(in("paint.json"));
    const Device device = open_device();
    double scale = 0;
    for (const Point& p : points) {
        const double theta = std::atan2(p.x - middle, below - p.y);
        const double radius = std::hypot(p.x - middle, p.y - below);
        if (std::abs(theta) > 85 * degree) // a tenth of a pixel is too much of these
            continue;
        const double f = value_at(device, material, direction(30 * degree, pi),
                                  direction(std::abs(theta), theta < 0 ? pi : 0));
        if (scale == 0)
            scale = radius / std::cbrt(f);
        EXPECT_NEAR(radius, scale * std::cbrt(f), 0.02 * radius) << theta / degree;
    }
    EXPECT_GT(scale, 0);
}

TEST_F(Plots, over_half_vectors_are_logarithms_of_values) {
    const std::string picture = svg({in("paint.json"), "--kind", "half", "--theta", "20"});
    const std::vector<Point> points = points_of(picture, 0);
    const Material material = read_material(in("paint.json"));
    const Device device = open_device();
    const auto f = [&](double theta_h) {
        const auto [wi, wo] = half_pair(theta_h * degree, 20 * degree);
        return value_at(device, material, wi, wo);
    };
    // Two heights tell the scale, the others must follow it.
    const auto height = [&](double theta_h) { return at(points, left + theta_h * 400 / 90); };
    const double decade = (height(60) - height(5)) / (std::log10(f(5)) - std::log10(f(60)));
    EXPECT_GT(decade, 0);
    for (const double theta_h : {10.0, 15.0, 25.0, 40.0, 75.0})
        EXPECT_NEAR(height(theta_h),
                    height(5) + decade * (std::log10(f(5)) - std::log10(f(theta_h))), 1.5)
            << theta_h;
}

TEST_F(Plots, end_before_the_horizon) {
    // A microfacet BRDF grows without bound there, and would stretch the axis beyond all use.
    write_file(in("metal.json"), R"({"brdfit": 1, "channels": ["a"],
        "diffuse": {"model": "lambert", "kd": [0]},
        "lobes": [{"model": "ggx", "ks": [1], "f0": 1, "a": 0.2}]})");
    EXPECT_EQ(svg({in("metal.json"), "--kind", "half"}).find("e+"), std::string::npos);
}

TEST_F(Plots, have_a_curve_for_each_input_and_angle) {
    const std::string picture =
        svg({in("paint.json"), in("brushed.json"), in("paint.csv"), "--theta", "20,50"});
    for (int curve = 0; curve < 6; ++curve)
        EXPECT_FALSE(points_of(picture, curve).empty()) << curve;
    EXPECT_TRUE(points_of(picture, 6).empty());
    for (const char* name : {"brushed, θi 50°", "paint.csv, θi 20°"})
        EXPECT_NE(picture.find(name), std::string::npos) << name;
}

TEST_F(Plots, of_a_channel_is_not_of_the_mean) {
    const std::string mean = svg({in("paint.json"), "--theta", "30"});
    const std::string blue = svg({in("paint.json"), "--theta", "30", "--channel", "B"});
    EXPECT_NE(mean.find("(mean over channels)"), std::string::npos);
    EXPECT_EQ(blue.find("(mean over channels)"), std::string::npos);
    expect_usage_error(plot("a.svg", {in("paint.json"), "--channel", "X"}), "--channel X");
}

TEST_F(Plots, a_slice_has_the_colours_of_values) {
    write_file(in("matt.json"), R"({"brdfit": 1, "channels": ["R", "G", "B"],
        "diffuse": {"model": "lambert", "kd": [0.9, 0.45, 0.1]}, "lobes": []})");
    ASSERT_EQ(plot("a.png", {in("matt.json"), "--kind", "slice"}).status, 0);
    ASSERT_EQ(plot("b.png", {in("matt.json"), "--kind", "slice", "--exposure", "1"}).status, 0);
    const Image image = read_png(in("a.png")), brighter = read_png(in("b.png"));
    // The middle of the picture, at twice its size.
    const std::size_t pixel = image.width * (148 * 2) + 184 * 2;
    const double kd[] = {0.9, 0.45, 0.1};
    for (std::size_t ch = 0; ch < 3; ++ch) {
        EXPECT_NEAR(image.planes[ch][pixel], kd[ch] / pi, 0.006) << ch;
        EXPECT_NEAR(brighter.planes[ch][pixel], 2 * kd[ch] / pi, 0.009) << ch;
    }
}

TEST_F(Plots, a_recovered_distribution_has_its_shape) {
    write_file(in("metal.json"), R"({"brdfit": 1, "channels": ["R", "G", "B"],
        "diffuse": {"model": "lambert", "kd": [0, 0, 0]},
        "lobes": [{"model": "beckmann-smith", "ks": [1, 1, 1], "f0": 0.8, "m": 0.3}]})");
    ASSERT_EQ(run_program({"synth", in("metal.json"), in("metal.binary")}).status, 0);
    ASSERT_EQ(
        run_program({"generate", "--from", in("metal.binary"), "-o", in("recovered.exr")}).status,
        0);
    const std::vector<Point> points =
        points_of(svg({in("recovered.exr"), "--kind", "distribution"}), 0);
    // Beckmann's: log p falls by tan^2(theta) / a^2, and by the fourth power of the cosine.
    const auto log_p = [](double theta) {
        const double t = std::tan(theta * degree);
        return (-t * t / 0.09 - 4 * std::log(std::cos(theta * degree))) / std::log(10.0);
    };
    const auto height = [&](double theta) { return at(points, left + theta * 400 / 90); };
    const double decade = (height(25) - height(10)) / (log_p(10) - log_p(25));
    EXPECT_GT(decade, 10);
    for (const double theta : {12.0, 15.0, 18.0, 22.0, 28.0})
        EXPECT_NEAR(height(theta), height(10) + decade * (log_p(10) - log_p(theta)), 0.12 * decade)
            << theta;
}

TEST_F(Plots, refuse_options_that_would_do_nothing) {
    const std::string paint = in("paint.json");
    expect_usage_error(plot("a.pdf", {paint}), "expected .svg or .png");
    expect_usage_error(plot("a.svg", {paint, "--kind", "slice", "--theta", "10"}), "--theta");
    expect_usage_error(plot("a.svg", {paint, "--kind", "slice", "--channel", "R"}), "--channel");
    expect_usage_error(plot("a.svg", {paint, "--exposure", "1"}), "--exposure");
    expect_usage_error(plot("a.svg", {paint, "--kind", "slice", "--top", "1"}), "--top");
    expect_usage_error(plot("a.svg", {paint, paint, "--kind", "slice"}), "one material");
    expect_usage_error(plot("a.svg", {paint, "--kind", "circle"}), "circle");
    expect_usage_error(plot("a.svg", {paint, "--theta", "90.5"}), "--theta");
    expect_input_error(plot("a.svg", {in("none.json")}), "none.json");
    expect_input_error(plot("nowhere/a.svg", {paint}), "nowhere");
    EXPECT_FALSE(std::filesystem::exists(in("a.svg")));
}

class Pictures : public Plots {
  protected:
    Outcome render(const std::string& out, std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"render", "--size", "16", "--samples", "16"});
        arguments.insert(arguments.end(), {"-o", in(out)});
        return run_program(arguments);
    }
};

TEST_F(Pictures, refuse_what_cannot_be_shown) {
    const std::string paint = in("paint.json");
    expect_usage_error(render("a.jpg", {paint}), ".exr");
    expect_usage_error(render("a.png", {paint, "--shape", "teapot"}), "teapot");
    expect_usage_error(render("a.png", {paint, "--light", "point:1,2"}), "point:1,2");
    expect_usage_error(render("a.png", {paint, "--environment", "none"}), "light");
    expect_usage_error(render("a.png", {paint, "--samples", "0"}), "--samples");
    expect_usage_error(render("a.png", {paint, "--compare"}), "--compare");
    expect_usage_error(render("a.exr", {paint, "--exposure", "1"}), "--exposure");
    expect_usage_error(render("a.png", {paint, "--pixel", "half"}), "--pixel");
    expect_usage_error(render("a.png", {paint, "--proposal", paint}), "--proposal");
    expect_usage_error(render("a.png", {paint, "--labels", "a,b"}), "--labels");
    expect_input_error(render("a.png", {paint, "--environment", in("none.exr")}), "none.exr");
    EXPECT_FALSE(std::filesystem::exists(in("a.png")));
}

} // namespace

} // namespace brdfit

#include "host/image/plot.hpp"
#include "host/image/plot_svg.hpp"
#include "host/image/svg.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit {

using namespace plot;

namespace {

constexpr double radius = height - 20, middle_x = left + width / 2, base = above + height;
constexpr double to_radians = 3.14159265358979323846 / 180;

/// The radius of y, as a share of `top`'s.
Point point_at(double degrees, double y, double top) {
    const double r = radius * std::cbrt(std::clamp(y / top, 0.0, 1.0));
    return {middle_x + r * std::sin(degrees * to_radians),
            base - r * std::cos(degrees * to_radians)};
}

Page drawn(const std::vector<Curve>& curves, const PlotOptions& options, bool embedded) {
    double top = options.top;
    std::vector<std::string> names;
    for (const Curve& curve : curves) {
        names.push_back(curve.name);
        for (const double y : curve.y)
            if (options.top <= 0 && std::isfinite(y))
                top = std::max(top, y);
    }
    top = top > 0 ? top : 1;
    Page page(embedded ? embedded_width : width_with(names),
              embedded ? embedded_height : height_with(names.size()), options.title,
              options.comment, embedded);
    for (int degrees = -90; degrees <= 90; degrees += 30) {
        const Point end = point_at(degrees, top, top);
        page.add(FMT_STRING("<path class=\"grid\" d=\"M{:g} {:g}L{:.1f} {:.1f}\"/>"
                            "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n"),
                 middle_x, base, end.x, end.y,
                 middle_x + (radius + 14) * std::sin(degrees * to_radians),
                 base + 4 - (radius + 12) * std::cos(degrees * to_radians), degrees);
    }
    // Rings at powers of ten and at the top one, which the cube root spreads.
    for (double y = std::pow(10, std::floor(std::log10(top))); y > top * 1e-3; y /= 10) {
        const double r = radius * std::cbrt(y / top);
        page.add(
            FMT_STRING("<path class=\"grid\" fill=\"none\" d=\"M{:.1f} {:g}a{:.1f} {:.1f} 0 0 1 "
                       "{:.1f} 0\"/><text x=\"{:.1f}\" y=\"{:g}\" "
                       "text-anchor=\"middle\">{:g}</text>\n"),
            middle_x - r, base, r, r, 2 * r, middle_x + r, base + 16, y);
    }
    page.add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}, by its cube root"
                        "</text>\n"),
             middle_x, base + 34, svg_escaped(options.y_title));
    for (std::size_t c = 0; c < curves.size(); ++c) {
        page.add(FMT_STRING("<path fill=\"none\" {} d=\""), stroke_of(c));
        std::vector<Point> run;
        for (std::size_t k = 0; k < curves[c].x.size(); ++k)
            if (std::isfinite(curves[c].y[k])) {
                run.push_back(point_at(curves[c].x[k], curves[c].y[k], top));
            } else {
                page.line(run);
                run.clear();
            }
        page.line(run);
        page.add(FMT_STRING("\"/>\n"));
        page.legend(c, names[c], left + width);
    }
    return page;
}

} // namespace

void write_polar_plot(const std::vector<Curve>& curves, const PlotOptions& options,
                      const std::string& path) {
    drawn(curves, options, false).write(path);
}

std::string polar_plot_element(const std::vector<Curve>& curves, const PlotOptions& options) {
    return drawn(curves, options, true).text();
}

void write_angle_picture(const Image& linear, const PlotOptions& options, const std::string& path) {
    constexpr double side = height;
    Page page(left + side + 60, height_with(0), options.title, options.comment);
    page.add(FMT_STRING("<image x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\" "
                        "preserveAspectRatio=\"none\" href=\"data:image/png;base64,{}\"/>\n"),
             left, above, side, side, base64(png_bytes(linear)));
    for (int degrees = 0; degrees <= 90; degrees += 15) {
        const double at = side * degrees / 90;
        page.add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>"
                            "<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"end\">{}</text>\n"),
                 left + at, above + side + 16, degrees, left - 6, above + side - at + 4, degrees);
    }
    page.add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n"
                        "<text transform=\"translate(16 {:g}) rotate(-90)\" "
                        "text-anchor=\"middle\">{}</text>\n"),
             left + side / 2, above + side + 34, svg_escaped(options.x_title), above + side / 2,
             svg_escaped(options.y_title));
    page.write(path);
}

} // namespace brdfit

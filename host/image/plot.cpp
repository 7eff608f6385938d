#include "host/image/plot.hpp"

#include "host/image/plot_svg.hpp"
#include "host/image/svg.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

using namespace plot;

namespace {

/// A top that shows all values, or all but a few that are more than twice as high as the rest.
double shown_top(const std::vector<Curve>& curves) {
    std::vector<double> values;
    for (const Curve& curve : curves)
        for (const double y : curve.y)
            if (std::isfinite(y) && y > 0)
                values.push_back(y);
    if (values.empty())
        return 1;
    std::sort(values.begin(), values.end());
    const double most = values.back(), usual = values[(values.size() - 1) * 9 / 10];
    const double top = std::max(most > 2 * usual ? 1.5 * usual : most, 1e-6);
    const double step = round_step(top);
    return step * std::ceil(top / step - 1e-9);
}

/// Where values stand on a plot's axes.
struct Axes {
    const PlotOptions& options;
    double top, bottom; ///< of y; bottom > 0: logarithmic

    double x(double value) const {
        const double from = options.x_from, to = options.x_to;
        return left + width * (options.logarithmic_x ? std::log(value / from) / std::log(to / from)
                                                     : (value - from) / (to - from));
    }
    double y(double value) const {
        const double share =
            bottom > 0 ? std::log(value / bottom) / std::log(top / bottom) : value / top;
        // What is far outside of the picture must not overflow a viewer's numbers.
        return above + height * (1 - std::clamp(std::isnan(share) ? -1.0 : share, -1.0, 3.0));
    }
};

/// From the highest value down to the lowest, but at most six decades.
Axes logarithmic_axes(const std::vector<Curve>& curves, const PlotOptions& options) {
    double most = 0, least = std::numeric_limits<double>::infinity();
    for (const Curve& curve : curves)
        for (const double y : curve.y)
            if (std::isfinite(y) && y > 0) {
                most = std::max(most, y);
                least = std::min(least, y);
            }
    most = options.top > 0 ? options.top : most > 0 ? most : 1;
    const double top = std::pow(10, std::ceil(std::log10(most) - 1e-9));
    least = std::clamp(least, top * 1e-6, top / 10);
    return {options, top, std::pow(10, std::floor(std::log10(least) + 1e-9))};
}

void add_grid(Page& page, const Axes& axes) {
    const PlotOptions& options = axes.options;
    const double range = options.x_to - options.x_from;
    const double x_step = range == 90 ? 15 : range == 180 ? 30 : round_step(range);
    const auto x_tick = [&](double x) {
        page.add(FMT_STRING("<path class=\"grid\" d=\"M{0:g} {1:g}v{2:g}\"/><text x=\"{0:g}\" "
                            "y=\"{3:g}\" text-anchor=\"middle\">{4:g}</text>\n"),
                 axes.x(x), above, height, above + height + 16, x);
    };
    if (options.logarithmic_x)
        for (double x = options.x_from; x <= options.x_to * (1 + 1e-9); x *= 10)
            x_tick(x);
    else
        for (int k = 0; k * x_step <= range * (1 + 1e-9); ++k)
            x_tick(options.x_from + k * x_step);
    const auto tick = [&](double y) {
        page.add(FMT_STRING("<path d=\"M{:g} {:g}h{:g}\" class=\"{}\"/><text x=\"{:g}\" "
                            "y=\"{:g}\" text-anchor=\"end\">{:g}</text>\n"),
                 left, axes.y(y), width, std::abs(y - 1) < 1e-9 ? "one" : "grid", left - 6,
                 axes.y(y) + 4, y);
    };
    if (axes.bottom > 0)
        for (double y = axes.bottom; y <= axes.top * (1 + 1e-9); y *= 10)
            tick(y);
    else {
        const double step = round_step(axes.top);
        for (int k = 0; k * step <= axes.top * (1 + 1e-9); ++k)
            tick(k * step);
    }
    page.add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n"
                        "<text transform=\"translate(16 {:g}) rotate(-90)\" "
                        "text-anchor=\"middle\">{}</text>\n"),
             left + width / 2, above + height + 34, svg_escaped(options.x_title),
             above + height / 2, svg_escaped(options.y_title));
}

/// The curve's line, and marks where it is cut off.
void add_curve(Page& page, const Axes& axes, const Curve& curve, std::size_t number) {
    // A picture within the picture, as it is cut off at its edges.
    page.add(FMT_STRING("<svg x=\"{0:g}\" y=\"{1:g}\" width=\"{2:g}\" height=\"{3:g}\" "
                        "viewBox=\"{0:g} {1:g} {2:g} {3:g}\"><path fill=\"none\" {4} d=\""),
             left, above, width, height, stroke_of(number));
    std::vector<Point> run, all;
    std::vector<double> cut; // x of the highest point of each run above the top
    double highest = 0;
    bool over = false;
    for (std::size_t k = 0; k < curve.x.size(); ++k) {
        const double y = curve.y[k];
        const bool beyond = y > axes.top * (1 + 1e-9);
        if (beyond && (!over || y > highest)) {
            if (over)
                cut.pop_back();
            cut.push_back(curve.x[k]);
            highest = y;
        }
        over = beyond;
        if (!std::isfinite(y) || (axes.bottom > 0 && y <= 0)) {
            page.line(run);
            run.clear();
            continue;
        }
        run.push_back({axes.x(curve.x[k]), axes.y(y)});
        all.push_back(run.back());
    }
    page.line(run);
    page.add(FMT_STRING("\"/></svg>\n"));
    if (axes.options.dots)
        for (const Point& at : all)
            page.add(FMT_STRING("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>\n"),
                     fill_of(number), at.x, at.y);
    for (const double x : cut)
        page.add(
            FMT_STRING("<g class=\"{}\"><path class=\"cut\" d=\"M{:.1f} {:g}l-4 7h8z\"/></g>\n"),
            fill_of(number), axes.x(x), above - 7);
}

} // namespace

std::vector<std::string> distinct_names(const std::vector<std::string>& paths) {
    // The last `folders` of a path's folders and its name.
    const auto name = [](const std::string& path, int detail) {
        std::filesystem::path rest(path);
        std::filesystem::path text = detail == 0 ? rest.stem() : rest.filename();
        for (int k = 1; k < detail && rest.has_parent_path() && rest != rest.parent_path(); ++k) {
            rest = rest.parent_path();
            text = rest.filename().empty() ? rest / text : rest.filename() / text;
        }
        return text.string();
    };
    std::vector<std::string> names;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        constexpr int most_detail = 64;
        int detail = 0;
        const auto unclear = [&](const std::string& other) {
            return other != paths[i] && name(other, detail) == name(paths[i], detail);
        };
        while (detail < most_detail && std::any_of(paths.begin(), paths.end(), unclear))
            ++detail;
        const auto end = paths.begin() + static_cast<std::ptrdiff_t>(i);
        const auto before = std::count(paths.begin(), end, paths[i]);
        names.push_back(name(paths[i], detail) +
                        (before > 0 ? fmt::format(" ({})", before + 1) : std::string()));
    }
    return names;
}

namespace {

Page drawn(const std::vector<Curve>& curves, const PlotOptions& options, bool embedded) {
    const Axes axes = options.logarithmic
                          ? logarithmic_axes(curves, options)
                          : Axes{options, options.top > 0 ? options.top : shown_top(curves), 0};
    std::vector<std::string> names;
    for (const Curve& curve : curves) {
        double most = 0;
        for (const double y : curve.y)
            most = std::isnan(y) ? most : std::max(most, y);
        const bool cut = most > axes.top * (1 + 1e-9);
        names.push_back(curve.name + (!cut               ? ""
                                      : std::isinf(most) ? ", up to infinity"
                                                         : fmt::format(", up to {:.3g}", most)));
    }
    Page page(embedded ? embedded_width : width_with(names),
              embedded ? embedded_height : height_with(names.size()), options.title,
              options.comment, embedded);
    add_grid(page, axes);
    for (std::size_t c = 0; c < curves.size(); ++c) {
        add_curve(page, axes, curves[c], c);
        page.legend(c, names[c], left + width);
    }
    return page;
}

} // namespace

void write_plot(const std::vector<Curve>& curves, const PlotOptions& options,
                const std::string& path) {
    drawn(curves, options, false).write(path);
}

std::string plot_element(const std::vector<Curve>& curves, const PlotOptions& options) {
    return drawn(curves, options, true).text();
}

} // namespace brdfit

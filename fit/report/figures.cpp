#include "fit/report/figures.hpp"

#include "fit/report/html.hpp"
#include "host/image/plot.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace brdfit {

namespace {

std::string key_html(const std::vector<Curve>& curves) {
    std::string text = "<ul class=\"key\">";
    for (std::size_t c = 0; c < curves.size(); ++c)
        text += fmt::format("<li>{}{}</li>", legend_mark(c), html(curves[c].name));
    return text + "</ul>\n";
}

std::string figure(const std::string& plot, const std::vector<Curve>& curves,
                   const std::string& caption) {
    return fmt::format("<figure>{}{}<figcaption>{}</figcaption></figure>\n", plot, key_html(curves),
                       html(caption));
}

/// Errors with so many lobes over the materials, in the order of the least of them.
std::string sorted_errors(const Overview& overview, std::size_t lobes) {
    std::vector<std::size_t> order(overview.results().materials.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    order.erase(std::remove_if(order.begin(), order.end(),
                               [&](std::size_t m) { return overview.best(m, lobes) == nullptr; }),
                order.end());
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return overview.best(a, lobes)->error() < overview.best(b, lobes)->error();
    });
    if (order.size() < 2)
        return "";
    std::vector<Curve> curves;
    for (const std::string& model : overview.models()) {
        Curve curve{model, {}, {}}; // by model, so that its colour is one in all figures
        for (std::size_t i = 0; i < order.size(); ++i) {
            const ReportedFit* const fit = overview.fit(order[i], {model, lobes});
            curve.x.push_back(static_cast<double>(i + 1));
            curve.y.push_back(fit != nullptr ? fit->error() : std::nan(""));
        }
        curves.push_back(std::move(curve));
    }
    PlotOptions options;
    const std::string what =
        fmt::format("Error of every model with {} lobe{}", lobes, lobes == 1 ? "" : "s");
    options.title = what + " over the materials, sorted by the least";
    options.y_title = fmt::format("{} error", name_of(overview.results().metric));
    options.x_title = "materials, by the least error";
    options.x_from = 0;
    options.x_to = static_cast<double>(order.size());
    options.logarithmic = true;
    return figure(plot_element(curves, options), curves, options.title + ".");
}

/// Geometric means of time and error, a curve a model, a point a number of lobes.
std::string errors_by_time(const Overview& overview) {
    std::vector<Curve> curves;
    double least = 1e300, most = 0;
    for (const std::string& model : overview.models()) {
        Curve curve{model, {}, {}};
        for (const std::size_t lobes : overview.lobes()) {
            double time = 0, error = 0, count = 0;
            for (std::size_t m = 0; m < overview.results().materials.size(); ++m) {
                const ReportedFit* const fit = overview.fit(m, {model, lobes});
                if (fit == nullptr || !(fit->result.seconds > 0) || !(fit->error() > 0))
                    continue;
                time += std::log(fit->result.seconds);
                error += std::log(fit->error());
                ++count;
            }
            if (count == 0)
                continue;
            curve.x.push_back(std::exp(time / count));
            curve.y.push_back(std::exp(error / count));
            least = std::min(least, curve.x.back());
            most = std::max(most, curve.x.back());
        }
        curves.push_back(std::move(curve));
    }
    if (most == 0)
        return "";
    PlotOptions options;
    options.title = "Error against time of a fit, geometric means over the materials";
    options.y_title = fmt::format("{} error", name_of(overview.results().metric));
    options.x_title = "time of a fit (s)";
    options.x_from = std::pow(10, std::floor(std::log10(least)));
    options.x_to = std::max(10 * options.x_from, std::pow(10, std::ceil(std::log10(most))));
    options.logarithmic = options.logarithmic_x = options.dots = true;
    return figure(plot_element(curves, options), curves,
                  options.title + "; a point a number of lobes, from one on.");
}

} // namespace

std::string figures_html(const Overview& overview) {
    std::string text;
    for (const std::size_t lobes : overview.lobes())
        text += sorted_errors(overview, lobes);
    if (!text.empty())
        text += errors_by_time(overview);
    return text.empty() ? "<p>Of two materials and more.</p>\n"
                        : "<div class=\"figures\">\n" + text + "</div>\n";
}

} // namespace brdfit

#include "host/image/plot_svg.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/image/plot.hpp"
#include "host/image/svg.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace brdfit::plot {

namespace {

/// Okabe and Ito 2008, "Color Universal Design"; black and yellow are as the page asks for.
constexpr std::size_t colours = 8, dashes = 4;
constexpr const char* dash[dashes] = {"", " stroke-dasharray=\"6 3\"", " stroke-dasharray=\"2 2\"",
                                      " stroke-dasharray=\"8 3 2 3\""};
constexpr const char* style =
    ".paper{fill:#fff}text{fill:#222}.grid{stroke:#ddd}.one{stroke:#888}"
    ".c0{stroke:#0072b2}.c1{stroke:#d55e00}.c2{stroke:#009e73}.c3{stroke:#cc79a7}"
    ".c4{stroke:#56b4e9}.c5{stroke:#c08a00}.c6{stroke:#000}.c7{stroke:#888}"
    ".f0{fill:#0072b2}.f1{fill:#d55e00}.f2{fill:#009e73}.f3{fill:#cc79a7}"
    ".f4{fill:#56b4e9}.f5{fill:#c08a00}.f6{fill:#000}.f7{fill:#888}"
    "@media (prefers-color-scheme:dark){.paper{fill:#181818}text{fill:#eee}.grid{stroke:#444}"
    ".one{stroke:#999}.c0{stroke:#4aa3df}.c1{stroke:#ff8a3c}.c6{stroke:#fff}.c7{stroke:#aaa}"
    ".f0{fill:#4aa3df}.f1{fill:#ff8a3c}.f6{fill:#fff}.f7{fill:#aaa}}";

/// Marks the points of a run [first, last] that a line needs within `most` of all of them: Douglas
/// and Peucker 1973, without recursion.
void mark_needed(const std::vector<Point>& points, std::vector<bool>& needed) {
    constexpr double most = 0.1;
    std::vector<std::pair<std::size_t, std::size_t>> runs{{0, points.size() - 1}};
    needed.front() = needed.back() = true;
    while (!runs.empty()) {
        const auto [first, last] = runs.back();
        runs.pop_back();
        const Point a = points[first], b = points[last];
        const double length = std::hypot(b.x - a.x, b.y - a.y);
        std::size_t farthest = first;
        double distance = most;
        for (std::size_t k = first + 1; k < last; ++k) {
            const Point p = points[k];
            const double d =
                length > 0
                    ? std::abs((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / length
                    : std::hypot(p.x - a.x, p.y - a.y);
            if (d > distance) {
                distance = d;
                farthest = k;
            }
        }
        if (farthest == first)
            continue;
        needed[farthest] = true;
        runs.emplace_back(first, farthest);
        runs.emplace_back(farthest, last);
    }
}

/// What stands in a comment of XML, which may hold no two hyphens.
std::string commented(std::string text) {
    std::replace(text.begin(), text.end(), '-', '_');
    return svg_escaped(text);
}

} // namespace

std::string stroke_of(std::size_t index) {
    return fmt::format("class=\"c{}\" stroke-width=\"1.5\"{}", index % colours,
                       dash[index / colours % dashes]);
}

std::string fill_of(std::size_t index) {
    return fmt::format("f{}", index % colours);
}

double width_with(const std::vector<std::string>& names) {
    constexpr double letter = 7; // about
    std::size_t longest = 0;
    for (const std::string& name : names)
        longest = std::max(longest, name.size());
    return std::max(656.0, left + width + 44 + letter * static_cast<double>(longest));
}

double height_with(std::size_t names) {
    return std::max(above + height + 44, above + 20 + line * static_cast<double>(names));
}

double round_step(double top) {
    const double decade = std::pow(10, std::floor(std::log10(top / 4)));
    for (const double factor : {5.0, 2.0})
        if (4 * factor * decade <= top * (1 + 1e-9))
            return factor * decade;
    return decade;
}

Page::Page(double wide, double tall, const std::string& title, const std::string& comment,
           bool embedded)
    : wide_(wide), tall_(tall), embedded_(embedded) {
    if (embedded)
        add(FMT_STRING("<svg class=\"plot\" role=\"img\" aria-label=\"{}\" "
                       "viewBox=\"0 0 {:g} {:g}\">\n"),
            svg_escaped(title), wide, tall);
    else
        add(FMT_STRING("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" "
                       "width=\"{0:g}\" height=\"{1:g}\" font-family=\"sans-serif\" "
                       "font-size=\"12\">\n<!-- {2} -->\n<style>{3}</style>\n"
                       "<rect class=\"paper\" width=\"{0:g}\" height=\"{1:g}\"/>\n"
                       "<text x=\"{4}\" y=\"18\" font-size=\"13\">{5}</text>\n"),
            wide, tall, commented(comment), style, left, svg_escaped(title));
}

void Page::legend(std::size_t index, const std::string& name, double x) {
    if (embedded_)
        return;
    const double y = above + 10 + plot::line * static_cast<double>(index);
    add(FMT_STRING("<path d=\"M{0:g} {1:g}h18\" {2}/><text x=\"{3:g}\" y=\"{4:g}\">{5}</text>\n"),
        x + 10, y, stroke_of(index), x + 34, y + 4, svg_escaped(name));
}

void Page::line(const std::vector<Point>& points) {
    if (points.empty())
        return;
    std::vector<bool> needed(points.size());
    mark_needed(points, needed);
    for (std::size_t k = 0; k < points.size(); ++k)
        if (needed[k])
            add(FMT_STRING("{}{:.1f} {:.1f}"), k == 0 ? "M" : "L", points[k].x, points[k].y);
}

std::string Page::text() {
    add(FMT_STRING("</svg>\n"));
    return {text_.data(), text_.size()};
}

void Page::write(const std::string& path) {
    const std::string svg = text();
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".png") {
        Image image = drawn_svg(svg, static_cast<std::size_t>(2 * wide_),
                                static_cast<std::size_t>(2 * tall_));
        image.channels.pop_back(); // the paper covers all
        image.planes.pop_back();
        return write_png(image, path);
    }
    if (ending != ".svg")
        throw UsageError(fmt::format("{}: unknown ending; expected .svg or .png", path));
    OutputFile file(path);
    file.write(svg);
    file.commit();
}

} // namespace brdfit::plot

namespace brdfit {

const char* plot_style() {
    return plot::style;
}

std::string legend_mark(std::size_t index) {
    return fmt::format("<svg class=\"mark\" aria-hidden=\"true\" viewBox=\"0 0 26 8\"><path "
                       "d=\"M1 4h24\" {}/></svg>",
                       plot::stroke_of(index));
}

} // namespace brdfit

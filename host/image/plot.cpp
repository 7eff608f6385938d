#include "host/image/plot.hpp"

#include "host/files/file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace brdfit {

namespace {

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
    return out;
}

} // namespace

void write_plot(const std::vector<Curve>& curves, const std::string& title, double top,
                const std::string& path, const std::string& comment) {
    static constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                              "#56b4e9", "#e69f00", "#000000", "#999999"};
    constexpr double left = 48, width = 400, above = 28, height = 240;
    const auto x_of = [&](double x) { return left + width * x / 90; };
    const auto y_of = [&](double y) { return above + height * (1 - y / top); };
    fmt::memory_buffer out;
    const auto add = [&](const auto&... arguments) {
        fmt::format_to(std::back_inserter(out), arguments...);
    };
    add(FMT_STRING(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 312\" width=\"640\" "
            "height=\"312\" font-family=\"sans-serif\" font-size=\"12\">\n"
            "<!-- {} -->\n<rect width=\"640\" height=\"312\" fill=\"white\"/>\n"
            "<clipPath id=\"a\"><rect x=\"{}\" y=\"{}\" width=\"{}\" "
            "height=\"{}\"/></clipPath>\n"
            "<text x=\"{}\" y=\"18\" font-size=\"13\">{}</text>\n"),
        escaped(comment), left, above, width, height, left, escaped(title));
    for (int degrees = 0; degrees <= 90; degrees += 15)
        add(FMT_STRING("<path d=\"M{0:g} {1:g}v{2:g}\" stroke=\"#ddd\"/><text x=\"{0:g}\" "
                       "y=\"{3:g}\" text-anchor=\"middle\">{4}</text>\n"),
            x_of(degrees), above, height, above + height + 16, degrees);
    const double step = top > 4 ? 1 : top > 1.5 ? 0.5 : top > 0.6 ? 0.2 : 0.05;
    for (int k = 0; k * step <= top + 1e-9; ++k)
        add(FMT_STRING("<path d=\"M{:g} {:g}h{:g}\" stroke=\"{}\"/><text x=\"{:g}\" y=\"{:g}\" "
                       "text-anchor=\"end\">{:g}</text>\n"),
            left, y_of(k * step), width, std::abs(k * step - 1) < 1e-9 ? "#888" : "#ddd", left - 6,
            y_of(k * step) + 4, k * step);
    add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">angle from the normal, "
                   "degrees</text>\n"),
        left + width / 2, above + height + 34);
    for (std::size_t c = 0; c < curves.size(); ++c) {
        const char* colour = colours[c % std::size(colours)];
        const char* dash = c < std::size(colours) ? "" : " stroke-dasharray=\"5 3\"";
        add(FMT_STRING("<path clip-path=\"url(#a)\" fill=\"none\" stroke=\"{}\" "
                       "stroke-width=\"1.5\"{} d=\""),
            colour, dash);
        bool drawing = false;
        for (std::size_t k = 0; k < curves[c].x.size(); ++k) {
            if (!std::isfinite(curves[c].y[k])) {
                drawing = false;
                continue;
            }
            // What is far above the picture must not overflow a viewer's numbers.
            add(FMT_STRING("{}{:.1f} {:.1f}"), drawing ? "L" : "M", x_of(curves[c].x[k]),
                y_of(std::clamp(curves[c].y[k], -top, 3 * top)));
            drawing = true;
        }
        const double y = above + 10 + 16 * static_cast<double>(c);
        add(FMT_STRING("\"/>\n<path d=\"M{0:g} {1:g}h18\" stroke=\"{2}\" stroke-width=\"1.5\"{3}/>"
                       "<text x=\"{4:g}\" y=\"{5:g}\">{6}</text>\n"),
            left + width + 10, y, colour, dash, left + width + 34, y + 4, escaped(curves[c].name));
    }
    add(FMT_STRING("</svg>\n"));
    OutputFile file(path);
    file.write(std::string_view(out.data(), out.size()));
    file.commit();
}

} // namespace brdfit

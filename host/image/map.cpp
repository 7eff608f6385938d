#include "host/image/map.hpp"

#include "host/files/file.hpp"
#include "host/image/svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace brdfit {

namespace {

constexpr double left = 64, above = 28, side = 8; // of a cell
constexpr int scale_steps = 40;

/// Where a value lies on an axis of cells of even width, in cells from the first edge.
double place(const std::vector<double>& edges, double value) {
    const auto next = std::upper_bound(edges.begin() + 1, edges.end() - 1, value);
    const auto cell = next - edges.begin() - 1;
    return static_cast<double>(cell) + (value - *(next - 1)) / (*next - *(next - 1));
}

/// What the ends of the colours stand for.
double end_of(const std::vector<double>& values) {
    std::vector<double> sizes;
    for (const double value : values)
        if (std::isfinite(value))
            sizes.push_back(std::abs(value));
    if (sizes.empty())
        return 1;
    const auto high = sizes.begin() + static_cast<std::ptrdiff_t>((sizes.size() - 1) * 95 / 100);
    std::nth_element(sizes.begin(), high, sizes.end());
    const double decade = std::pow(10, std::floor(std::log10(std::max(*high, 1e-6))));
    for (const double factor : {1.0, 2.0, 5.0})
        if (*high <= factor * decade * (1 + 1e-9))
            return factor * decade;
    return 10 * decade;
}

/// Blue at -1, white at 0, red at 1.
std::string colour(double at) {
    constexpr std::array<double, 3> below{33, 102, 172}, over{178, 24, 43};
    const double share = std::min(std::abs(at), 1.0);
    std::array<int, 3> rgb{};
    for (std::size_t c = 0; c < rgb.size(); ++c)
        rgb[c] = static_cast<int>(std::lround(255 + share * ((at < 0 ? below[c] : over[c]) - 255)));
    return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

} // namespace

void write_map(const Map& map, const std::string& path) {
    const std::size_t columns = map.x.size() - 1, rows = map.y.size() - 1;
    const double width = side * static_cast<double>(columns),
                 height = side * static_cast<double>(rows), bottom = above + height;
    const double end = end_of(map.values);
    fmt::memory_buffer out;
    const auto add = [&](const auto&... arguments) {
        fmt::format_to(std::back_inserter(out), arguments...);
    };
    std::string comment = map.comment; // in which XML allows no two hyphens
    std::replace(comment.begin(), comment.end(), '-', '_');
    comment = svg_escaped(comment);
    const double whole_width = left + width + 110, whole_height = bottom + 44;
    add(FMT_STRING("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" "
                   "width=\"{0:g}\" height=\"{1:g}\" font-family=\"sans-serif\" "
                   "font-size=\"12\">\n<!-- {2} -->\n"
                   "<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"white\"/>\n"
                   "<rect x=\"{3:g}\" y=\"{4:g}\" width=\"{5:g}\" height=\"{6:g}\" "
                   "fill=\"#ccc\"/>\n<text x=\"{3:g}\" y=\"18\" font-size=\"13\">{7}</text>\n"
                   "<g shape-rendering=\"crispEdges\">\n"),
        whole_width, whole_height, comment, left, above, width, height, svg_escaped(map.title));
    for (std::size_t y = 0; y < rows; ++y)
        for (std::size_t x = 0; x < columns; ++x)
            if (const double value = map.values[y * columns + x]; std::isfinite(value))
                add(FMT_STRING("<rect class=\"cell\" x=\"{0:g}\" y=\"{1:g}\" width=\"{4:g}\" "
                               "height=\"{4:g}\" fill=\"{2}\"><title>{3:.3g}</title></rect>\n"),
                    left + side * static_cast<double>(x),
                    bottom - side * static_cast<double>(y + 1), colour(value / end), value, side);
    const double step = height / scale_steps;
    for (int k = 0; k < scale_steps; ++k)
        add(FMT_STRING("<rect x=\"{:g}\" y=\"{:g}\" width=\"14\" height=\"{:g}\" "
                       "fill=\"{}\"/>\n"),
            left + width + 20, above + step * k, step, colour(1 - (2 * k + 1.0) / scale_steps));
    add(FMT_STRING("</g>\n"));
    for (const double at : {-1.0, -0.5, 0.0, 0.5, 1.0})
        add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\">{:+g}</text>\n"), left + width + 38,
            above + height * (1 - at) / 2 + 4, at * end);
    add(FMT_STRING("<text transform=\"translate({:g} {:g}) rotate(-90)\" "
                   "text-anchor=\"middle\">{}</text>\n"),
        left + width + 100, above + height / 2, svg_escaped(map.scale_title));
    for (const double tick : map.x_ticks)
        add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{:g}</text>\n"),
            left + side * place(map.x, tick), bottom + 16, tick);
    for (const double tick : map.y_ticks)
        add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"end\">{:g}</text>\n"), left - 6,
            bottom - side * place(map.y, tick) + 4, tick);
    add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n"
                   "<text transform=\"translate(16 {:g}) rotate(-90)\" text-anchor=\"middle\">{}"
                   "</text>\n</svg>\n"),
        left + width / 2, bottom + 34, svg_escaped(map.x_title), above + height / 2,
        svg_escaped(map.y_title));
    OutputFile file(path);
    file.write(std::string_view(out.data(), out.size()));
    file.commit();
}

} // namespace brdfit

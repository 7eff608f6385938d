#include "host/image/plot.hpp"

#include "host/files/file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
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

/// What stands in a comment of XML, which may hold no two hyphens.
std::string commented(std::string text) {
    std::replace(text.begin(), text.end(), '-', '_');
    return escaped(text);
}

/// 1, 2 or 5 times a power of ten, 4 to 10 of which come to `top`.
double round_step(double top) {
    const double decade = std::pow(10, std::floor(std::log10(top / 4)));
    for (const double factor : {5.0, 2.0})
        if (4 * factor * decade <= top * (1 + 1e-9))
            return factor * decade;
    return decade;
}

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

constexpr double left = 64, width = 400, above = 28, height = 240, line = 16;
constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#56b4e9", "#e69f00", "#000000", "#999999"};
constexpr const char* dashes[] = {"", " stroke-dasharray=\"6 3\"", " stroke-dasharray=\"2 2\"",
                                  " stroke-dasharray=\"8 3 2 3\""};

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

void write_plot(const std::vector<Curve>& curves, const PlotOptions& options,
                const std::string& path) {
    const double top = options.top > 0 ? options.top : shown_top(curves);
    const auto x_of = [&](double x) { return left + width * x / 90; };
    const auto y_of = [&](double y) { return above + height * (1 - y / top); };
    // What the legend says, and how far its letters go, about.
    std::vector<std::string> names;
    std::size_t longest = 0;
    for (const Curve& curve : curves) {
        double most = 0;
        for (const double y : curve.y)
            most = std::isnan(y) ? most : std::max(most, y);
        const bool cut = most > top * (1 + 1e-9);
        names.push_back(curve.name + (!cut               ? ""
                                      : std::isinf(most) ? ", up to infinity"
                                                         : fmt::format(", up to {:.3g}", most)));
        longest = std::max(longest, names.back().size());
    }
    const double whole = std::max(656.0, left + width + 44 + 7 * static_cast<double>(longest));
    const double tall =
        std::max(above + height + 44, above + 20 + line * static_cast<double>(curves.size()));
    fmt::memory_buffer out;
    const auto add = [&](const auto&... arguments) {
        fmt::format_to(std::back_inserter(out), arguments...);
    };
    add(FMT_STRING("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" "
                   "width=\"{0:g}\" height=\"{1:g}\" font-family=\"sans-serif\" "
                   "font-size=\"12\">\n<!-- {2} -->\n"
                   "<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"white\"/>\n"
                   "<clipPath id=\"a\"><rect x=\"{3}\" y=\"{4}\" width=\"{5}\" "
                   "height=\"{6}\"/></clipPath>\n"
                   "<text x=\"{3}\" y=\"18\" font-size=\"13\">{7}</text>\n"),
        whole, tall, commented(options.comment), left, above, width, height,
        escaped(options.title));
    for (int degrees = 0; degrees <= 90; degrees += 15)
        add(FMT_STRING("<path d=\"M{0:g} {1:g}v{2:g}\" stroke=\"#ddd\"/><text x=\"{0:g}\" "
                       "y=\"{3:g}\" text-anchor=\"middle\">{4}</text>\n"),
            x_of(degrees), above, height, above + height + 16, degrees);
    const double step = round_step(top);
    for (int k = 0; k * step <= top * (1 + 1e-9); ++k)
        add(FMT_STRING("<path d=\"M{:g} {:g}h{:g}\" stroke=\"{}\"/><text x=\"{:g}\" y=\"{:g}\" "
                       "text-anchor=\"end\">{:g}</text>\n"),
            left, y_of(k * step), width, std::abs(k * step - 1) < 1e-9 ? "#888" : "#ddd", left - 6,
            y_of(k * step) + 4, k * step);
    add(FMT_STRING("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">angle from the normal "
                   "(degrees)</text>\n"
                   "<text transform=\"translate(16 {:g}) rotate(-90)\" text-anchor=\"middle\">{}"
                   "</text>\n"),
        left + width / 2, above + height + 34, above + height / 2, escaped(options.y_title));
    for (std::size_t c = 0; c < curves.size(); ++c) {
        const Curve& curve = curves[c];
        const char* colour = colours[c % std::size(colours)];
        const char* dash = dashes[c / std::size(colours) % std::size(dashes)];
        add(FMT_STRING("<path clip-path=\"url(#a)\" fill=\"none\" stroke=\"{}\" "
                       "stroke-width=\"1.5\"{} d=\""),
            colour, dash);
        bool drawing = false;
        std::vector<double> cut; // x of the highest point of each run above the top
        double highest = top * (1 + 1e-9);
        bool over = false;
        for (std::size_t k = 0; k < curve.x.size(); ++k) {
            const double y = curve.y[k];
            const bool beyond = y > top * (1 + 1e-9);
            if (beyond && (!over || y > highest)) {
                if (over)
                    cut.pop_back();
                cut.push_back(curve.x[k]);
                highest = y;
            }
            over = beyond;
            if (!std::isfinite(y)) {
                drawing = false;
                continue;
            }
            // What is far above the picture must not overflow a viewer's numbers.
            add(FMT_STRING("{}{:.1f} {:.1f}"), drawing ? "L" : "M", x_of(curve.x[k]),
                y_of(std::clamp(y, -top, 3 * top)));
            drawing = true;
        }
        add(FMT_STRING("\"/>\n"));
        for (const double x : cut)
            add(FMT_STRING("<path class=\"cut\" d=\"M{:.1f} {:g}l-4 7h8z\" fill=\"{}\"/>\n"),
                x_of(x), above - 7, colour);
        const double y = above + 10 + line * static_cast<double>(c);
        add(FMT_STRING("<path d=\"M{0:g} {1:g}h18\" stroke=\"{2}\" stroke-width=\"1.5\"{3}/>"
                       "<text x=\"{4:g}\" y=\"{5:g}\">{6}</text>\n"),
            left + width + 10, y, colour, dash, left + width + 34, y + 4, escaped(names[c]));
    }
    add(FMT_STRING("</svg>\n"));
    OutputFile file(path);
    file.write(std::string_view(out.data(), out.size()));
    file.commit();
}

} // namespace brdfit

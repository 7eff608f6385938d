#pragma once

#include <cstddef>
#include <fmt/format.h>
#include <iterator>
#include <string>
#include <vector>

// What the plots of plot.hpp share: a page that is legible in light and dark, colours that the
// colour-blind tell apart, a legend, round ticks.

namespace brdfit::plot {

inline constexpr double left = 64, width = 400, above = 28, height = 240, line = 16;

struct Point {
    double x, y;
};

/// A growing SVG text.
class Page {
  public:
    /// Begins a page of that size, with a title and a comment for those who read the file, or where
    /// `embedded` an element of another one, which reads out the title and has no legend.
    Page(double wide, double tall, const std::string& title, const std::string& comment,
         bool embedded = false);

    template <typename Format, typename... Arguments>
    void add(const Format& format, const Arguments&... arguments) {
        fmt::format_to(std::back_inserter(text_), format, arguments...);
    }
    /// A curve's legend entry, number `index`, at x.
    void legend(std::size_t index, const std::string& name, double x);
    double wide() const { return wide_; }
    double tall() const { return tall_; }
    /// A line through points in the order of x, without those that change it by less than a tenth
    /// of a unit.
    void line(const std::vector<Point>& points);
    /// Ends the page and returns it.
    std::string text();
    /// Writes the page: .svg, or .png drawn at twice its size. Throws UsageError for other endings.
    void write(const std::string& path);

  private:
    double wide_, tall_;
    bool embedded_;
    fmt::memory_buffer text_;
};

/// The attributes of curve number `index`'s line.
std::string stroke_of(std::size_t index);
/// The class that gives a filled mark its curve's colour.
std::string fill_of(std::size_t index);

/// Size of an embedded one.
inline constexpr double embedded_width = left + width + 24, embedded_height = above + height + 44;
/// Size of a page that has a legend of these names to the right of its axes.
double width_with(const std::vector<std::string>& names);
double height_with(std::size_t names);

/// 1, 2 or 5 times a power of ten, 4 to 10 of which come to `top`.
double round_step(double top);

} // namespace brdfit::plot

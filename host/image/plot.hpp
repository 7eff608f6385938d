#pragma once

#include <string>
#include <vector>

namespace brdfit {

/// A curve of a plot.
struct Curve {
    std::string name;
    std::vector<double> x, y; ///< y: values that are not finite end a line
};

/// Writes curves as an SVG picture: x from 0 to 90 degrees, y from 0 to `top`, a legend, and a line
/// at y = 1. The same bytes for the same curves.
void write_plot(const std::vector<Curve>& curves, const std::string& title, double top,
                const std::string& path, const std::string& comment);

} // namespace brdfit

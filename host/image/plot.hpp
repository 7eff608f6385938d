#pragma once

#include <string>
#include <vector>

namespace brdfit {

/// A curve of a plot.
struct Curve {
    std::string name;
    std::vector<double> x, y; ///< x: degrees; y: values that are not finite end a line
};

struct PlotOptions {
    std::string title, y_title;
    std::string comment; ///< for those who read the file
    /// Largest y shown; 0: a round number above all values, but for those of a few points that
    /// would flatten the rest. What is above is cut off and marked, with the largest in the legend.
    double top = 0;
};

/// Writes curves as an SVG picture: x, the angle from the normal, from 0 to 90 degrees, y from 0, a
/// legend, and a line at y = 1. The same bytes for the same curves.
void write_plot(const std::vector<Curve>& curves, const PlotOptions& options,
                const std::string& path);

/// Names for a legend that tell paths apart: the file's stem, with ending and as many folders as
/// that takes, and a number where a path is given twice.
std::vector<std::string> distinct_names(const std::vector<std::string>& paths);

} // namespace brdfit

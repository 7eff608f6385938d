#pragma once

#include "host/image/image.hpp"

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
    std::string x_title = "angle from the normal (degrees)";
    double x_from = 0, x_to = 90;
    bool logarithmic = false;   ///< y, over at most six decades
    bool logarithmic_x = false; ///< from x_from > 0
    bool dots = false;          ///< at the points of curves
};

/// Writes curves as an SVG picture, or a PNG one by the path's ending, legible in light and dark:
/// y from 0, a legend, and a line at y = 1. The same bytes for the same curves. Throws UsageError
/// for other endings.
void write_plot(const std::vector<Curve>& curves, const PlotOptions& options,
                const std::string& path);

/// The same in polar coordinates over the incidence plane, x from -90 to 90 degrees from the normal
/// upwards, the radius the cube root of y, which shows dim parts beside highlights (Fig. 7 of Kurt
/// et al. 2010). The rings are round values of y.
void write_polar_plot(const std::vector<Curve>& curves, const PlotOptions& options,
                      const std::string& path);

/// The plots of write_plot and write_polar_plot as elements of an HTML page that has plot_style():
/// their titles are read out, a legend is made of legend_mark.
std::string plot_element(const std::vector<Curve>& curves, const PlotOptions& options);
std::string polar_plot_element(const std::vector<Curve>& curves, const PlotOptions& options);
const char* plot_style();
/// The line of curve number `index`, an element too.
std::string legend_mark(std::size_t index);

/// A picture over two angles of 0 to 90 degrees, x to the right and y upwards, as it is on a
/// screen. `linear`: R, G, B in [0, 1].
void write_angle_picture(const Image& linear, const PlotOptions& options, const std::string& path);

/// Names for a legend that tell paths apart: the file's stem, with ending and as many folders as
/// that takes, and a number where a path is given twice.
std::vector<std::string> distinct_names(const std::vector<std::string>& paths);

} // namespace brdfit

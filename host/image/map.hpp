#pragma once

#include <string>
#include <vector>

namespace brdfit {

/// Signed numbers over two angles.
struct Map {
    std::string title, x_title, y_title, scale_title;
    std::string comment;         ///< for those who read the file
    std::vector<double> x, y;    ///< edges of cells, degrees, ascending; drawn in even steps
    std::vector<double> x_ticks; ///< degrees
    std::vector<double> y_ticks; ///< degrees
    std::vector<double> values;  ///< [y][x]; NaN: nothing there
};

/// Writes a map as an SVG picture, y upwards: white at 0, blue below, red above, grey where nothing
/// is. The colours end at the 95th percentile of the magnitudes, rounded up; what is beyond has the
/// last one. The same bytes for the same map.
void write_map(const Map& map, const std::string& path);

} // namespace brdfit

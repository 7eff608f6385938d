#include "host/albedo/nearest.hpp"

#include <algorithm>
#include <cmath>

namespace brdfit {

Nearest::Nearest(std::vector<Vector> directions)
    : directions_(std::move(directions)),
      side_(1 + static_cast<std::size_t>(std::sqrt(static_cast<double>(directions_.size()) / 2))),
      cells_(side_ * side_) {
    for (std::size_t i = 0; i < directions_.size(); ++i)
        cells_[cell(directions_[i][1]) * side_ + cell(directions_[i][0])].push_back(i);
}

std::size_t Nearest::cell(double x) const {
    const double at = (x + 1) / 2 * static_cast<double>(side_);
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(side_ - 1)));
}

std::vector<std::pair<double, std::size_t>> Nearest::find(const Vector& at, std::size_t k) const {
    std::vector<std::pair<double, std::size_t>> best;
    const auto cx = static_cast<std::ptrdiff_t>(cell(at[0]));
    const auto cy = static_cast<std::ptrdiff_t>(cell(at[1]));
    const auto side = static_cast<std::ptrdiff_t>(side_);
    const double width = 2 / static_cast<double>(side_);
    // Rings of cells: what lies in ring r is at least r - 1 cells away, also in space.
    for (std::ptrdiff_t ring = 0; ring < side; ++ring) {
        const double clear = std::max<double>(0, static_cast<double>(ring - 1)) * width;
        if (best.size() == k && best.back().first <= clear * clear)
            break;
        for (std::ptrdiff_t y = std::max<std::ptrdiff_t>(0, cy - ring);
             y <= std::min(side - 1, cy + ring); ++y) {
            const bool edge = std::abs(y - cy) == ring;
            for (std::ptrdiff_t x = cx - ring; x <= cx + ring;
                 x += edge || ring == 0 ? 1 : 2 * ring) {
                if (x < 0 || x >= side)
                    continue;
                for (const std::size_t i : cells_[static_cast<std::size_t>(y * side + x)]) {
                    double d2 = 0;
                    for (std::size_t a = 0; a < 3; ++a)
                        d2 += (directions_[i][a] - at[a]) * (directions_[i][a] - at[a]);
                    if (best.size() == k && d2 >= best.back().first)
                        continue;
                    const std::pair<double, std::size_t> found{d2, i};
                    best.insert(std::upper_bound(best.begin(), best.end(), found), found);
                    if (best.size() > k)
                        best.pop_back();
                }
            }
        }
    }
    return best;
}

} // namespace brdfit

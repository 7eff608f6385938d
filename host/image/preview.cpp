#include "host/image/preview.hpp"

#include "host/error.hpp"
#include "host/image/image.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

namespace brdfit {

void require_preview_ending(const std::string& path) {
    if (std::filesystem::path(path).extension() != ".png")
        throw UsageError(fmt::format("{}: unknown ending; expected .png for a preview", path));
}

std::string write_preview(const std::vector<PreviewPanel>& panels, const std::string& path) {
    require_preview_ending(path);
    // Pixels each way: a panel has 256 of them or as many as it has values, up to 2048.
    constexpr std::size_t least_side = 256, most_side = 2048, gap = 8;
    constexpr float between = 0.2F;
    const auto enlarged = [&](std::size_t side) {
        return std::min(most_side, side * std::max<std::size_t>(1, least_side / side));
    };
    Image image;
    for (const PreviewPanel& panel : panels) {
        image.width += enlarged(panel.width) + (image.width > 0 ? gap : 0);
        image.height = std::max(image.height, enlarged(panel.height));
    }
    image.channels = {"Y"};
    std::vector<float>& pixels = image.planes.emplace_back(image.width * image.height, between);
    std::string seen = "from left to right ";
    std::size_t left = 0;
    for (const PreviewPanel& panel : panels) {
        float most = 0;
        for (const float value : panel.values)
            most = std::isfinite(value) ? std::max(most, value) : most;
        const std::size_t across = enlarged(panel.width), down = enlarged(panel.height);
        for (std::size_t y = 0; y < down; ++y)
            for (std::size_t x = 0; x < across; ++x) {
                const float value =
                    panel.values[y * panel.height / down * panel.width + x * panel.width / across];
                pixels[y * image.width + left + x] = most > 0 ? value / most : 0;
            }
        left += across + gap;
        seen += fmt::format("{}{} (white {:.4g})", &panel == panels.data() ? "" : ", ", panel.name,
                            most);
    }
    write_png(image, path);
    return seen;
}

} // namespace brdfit

#include "host/render/picture.hpp"

#include "host/image/svg.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit {

Image image_of(const Film& film) {
    Image image;
    image.width = film.width();
    image.height = film.height();
    image.channels = {"R", "G", "B", "A"};
    for (const Film::Plane plane : {Film::Red, Film::Green, Film::Blue, Film::Covered}) {
        std::vector<float>& values = image.planes.emplace_back(film.pixels());
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(film.mean(plane, i));
    }
    return image;
}

Image toned(const Image& image, double exposure, Tone tone) {
    Image made;
    made.width = image.width;
    made.height = image.height;
    made.channels = {"R", "G", "B"};
    made.planes.assign(3, std::vector<float>(image.width * image.height));
    const double scale = std::exp2(exposure);
    for (std::size_t i = 0; i < made.planes[0].size(); ++i) {
        double rgb[3];
        for (std::size_t ch = 0; ch < 3; ++ch)
            rgb[ch] = std::max(0.0, scale * image.planes[ch][i]);
        const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        const double by =
            tone == Tone::Clip ? 1 : (1 + luminance / (tone_white * tone_white)) / (1 + luminance);
        for (std::size_t ch = 0; ch < 3; ++ch)
            made.planes[ch][i] = static_cast<float>(std::min(1.0, by * rgb[ch]));
    }
    return made;
}

Image side_by_side(const std::vector<Panel>& panels, std::size_t columns) {
    const std::size_t width = panels[0].image.width, height = panels[0].image.height;
    Image made;
    made.width = width * std::min(columns, panels.size());
    made.height = height * ((panels.size() + columns - 1) / columns);
    made.channels = panels[0].image.channels;
    made.planes.assign(made.channels.size(), std::vector<float>(made.width * made.height));
    for (std::size_t k = 0; k < panels.size(); ++k)
        for (std::size_t ch = 0; ch < made.planes.size(); ++ch)
            for (std::size_t y = 0; y < height; ++y)
                std::copy_n(
                    panels[k].image.planes[ch].begin() + static_cast<std::ptrdiff_t>(y * width),
                    width,
                    made.planes[ch].begin() +
                        static_cast<std::ptrdiff_t>((k / columns * height + y) * made.width +
                                                    k % columns * width));
    return made;
}

Image labelled(const Image& toned, const std::vector<Panel>& panels, std::size_t columns) {
    const std::size_t width = panels[0].image.width, height = panels[0].image.height;
    // Letters that fit: sans-serif ones are about half as wide as high.
    std::size_t longest = 1;
    for (const Panel& panel : panels)
        longest = std::max(longest, panel.label.size());
    const double size = std::min(std::max(9.0, static_cast<double>(height) / 24),
                                 1.7 * static_cast<double>(width) / static_cast<double>(longest));
    std::string svg = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" "
                                  "height=\"{}\" font-family=\"sans-serif\" font-size=\"{:.1f}\">",
                                  toned.width, toned.height, size);
    // A dark edge first, then the letters: both show on any picture.
    for (const char* ink : {"fill=\"none\" stroke=\"black\"", "fill=\"white\""})
        for (std::size_t k = 0; k < panels.size(); ++k)
            svg +=
                fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" stroke-width=\"{:.1f}\" {}>{}</text>",
                            static_cast<double>(k % columns * width) + 0.5 * size,
                            static_cast<double>((k / columns + 1) * height) - 0.5 * size, size / 5,
                            ink, svg_escaped(panels[k].label));
    const Image text = drawn_svg(svg + "</svg>", toned.width, toned.height);
    Image made = toned;
    for (std::size_t ch = 0; ch < 3; ++ch)
        for (std::size_t i = 0; i < made.planes[ch].size(); ++i)
            made.planes[ch][i] = text.planes[ch][i] + (1 - text.planes[3][i]) * made.planes[ch][i];
    return made;
}

} // namespace brdfit

#pragma once

#include "host/image/image.hpp"
#include "host/render/film.hpp"

#include <map>
#include <string>
#include <vector>

namespace brdfit {

/// A picture of a scene under its name.
struct Panel {
    std::string label;
    Image image; ///< R, G, B (linear, W/(m2 sr)) and A, the share that shapes cover
};
Image image_of(const Film& film);

/// How linear light becomes what a screen shows.
enum class Tone {
    Clip,    ///< sRGB of what is at most 1
    Reinhard ///< Reinhard et al. 2002, Eq. 4, of the luminance, which tone_white maps to 1
};
inline constexpr double tone_white = 4;

/// R, G, B of a screen, 0 to 1, linear: times 2^exposure, then the tone.
Image toned(const Image& image, double exposure, Tone tone);

/// Panels of one size in rows of `columns`, R, G, B and A.
Image side_by_side(const std::vector<Panel>& panels, std::size_t columns);
/// A toned picture of panels with their labels over it.
Image labelled(const Image& toned, const std::vector<Panel>& panels, std::size_t columns);

} // namespace brdfit

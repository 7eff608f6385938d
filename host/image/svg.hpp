#pragma once

#include "host/image/image.hpp"

#include <cstddef>
#include <string>

namespace brdfit {

/// Text as it stands in SVG, whatever characters it has.
std::string svg_escaped(const std::string& text);

/// Bytes as they stand in a data: address (RFC 4648).
std::string base64(const std::string& bytes);

/// What an SVG picture shows at a size in pixels: linear light in R, G, B, as it is over black, and
/// the share A that is covered, 0 to 1. Throws InputError where it cannot be drawn.
Image drawn_svg(const std::string& svg, std::size_t width, std::size_t height);

} // namespace brdfit

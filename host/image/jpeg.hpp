#pragma once

#include "host/image/image.hpp"

#include <string>

namespace brdfit {

/// The bytes of a JPEG file of R, G, B in linear light, as a screen shows them (sRGB): a tenth of a
/// PNG file's where a picture has noise. Throws UsageError for an image without those planes,
/// InputError where it cannot be made.
std::string jpeg_bytes(const Image& image);

} // namespace brdfit

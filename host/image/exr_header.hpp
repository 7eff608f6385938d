#pragma once

#include <string_view>

namespace brdfit {

/// Walks the headers of an OpenEXR file, for OpenEXR allocates what they say. Throws InputError
/// with the place (part, attribute, byte) where an attribute does not end within the file, headers
/// take more than 64 MiB, parts or attributes are too many, or where channels, data window, tiles
/// and table of chunks are more than check_image_size allows or than the file can hold.
void check_exr_headers(std::string_view bytes);

} // namespace brdfit

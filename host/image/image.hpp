#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace brdfit {

/// Named planes of equal size, with text metadata; row 0 is the top one.
struct Image {
    std::size_t width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<std::vector<float>> planes;      ///< [channel][y * width + x]
    std::map<std::string, std::string> metadata; ///< by attribute name

    /// The plane of that name, or nullptr.
    const std::vector<float>* plane(const std::string& channel) const;
};

/// How an OpenEXR file stores its values.
enum class ExrPixel { Half, Float };

/// The flat image of an OpenEXR file (its first part), scan lines or tiles, channels in the file's
/// (alphabetical) order, metadata its string attributes. Throws InputError naming the file where it
/// is missing, broken, truncated, deep, subsampled or larger than 2^26 values.
Image read_exr(const std::string& path);
/// Writes the image, ZIP-compressed, whole or not at all. Throws InputError where it cannot, and
/// UsageError where planes and sizes disagree or names repeat.
void write_exr(const Image& image, const std::string& path, ExrPixel pixel);

/// All parts of an OpenEXR file, each as read_exr reads the first; metadata `name` is a part's
/// name. Throws InputError like read_exr, and where there are more than 1024 parts or their values
/// exceed the limit together.
std::vector<Image> read_exr_parts(const std::string& path);
/// Writes images of any sizes as the parts of one file; each has metadata `name`, all different.
/// Throws like write_exr.
void write_exr_parts(const std::vector<Image>& parts, const std::string& path, ExrPixel pixel);

/// The image of a PNG file of any kind, as linear light in [0, 1] (files without gamma: sRGB, at 16
/// bits linear): channel Y where it is grey, otherwise R, G, B; what is transparent is black.
/// Throws InputError naming the file where it is missing, broken, truncated or larger than 2^26
/// values.
Image read_png(const std::string& path);

/// Writes linear light, one plane grey or three red, green, blue, as 8 bits of sRGB a value, whole
/// or not at all; what is outside of 0 to 1 is cut off, what is no number black. Throws InputError
/// where it cannot, and UsageError where planes and sizes disagree.
void write_png(const Image& image, const std::string& path);
/// The bytes of that file.
std::string png_bytes(const Image& image);

/// read_exr or read_png, by content. Throws InputError also where it is neither.
Image read_image(const std::string& path);

} // namespace brdfit

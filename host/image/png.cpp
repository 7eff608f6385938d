#include "host/image/image.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/image/limits.hpp"
#include "host/image/srgb.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <memory>
#include <png.h>

namespace brdfit {

namespace {

constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view exr_signature = "\x76\x2f\x31\x01";

bool starts_with(std::string_view bytes, std::string_view signature) {
    return bytes.substr(0, signature.size()) == signature;
}

std::uint8_t byte_of(float light) {
    return static_cast<std::uint8_t>(std::lround(255 * srgb_of_linear(light)));
}

} // namespace

std::string png_bytes(const Image& image) {
    const std::size_t channels = image.planes.size(), count = image.width * image.height;
    const bool whole =
        std::all_of(image.planes.begin(), image.planes.end(),
                    [&](const std::vector<float>& plane) { return plane.size() == count; });
    if (count == 0 || (channels != 1 && channels != 3) || !whole)
        throw UsageError(fmt::format("a PNG image of {} x {} pixels and {} planes; expected 1 or 3 "
                                     "planes of that size",
                                     image.width, image.height, channels));
    std::vector<std::uint8_t> values;
    values.reserve(count * channels);
    for (std::size_t i = 0; i < count; ++i)
        for (const std::vector<float>& plane : image.planes)
            values.push_back(byte_of(plane[i]));
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
    const std::unique_ptr<png_image, void (*)(png_image*)> freed(&png, png_image_free);
    png_alloc_size_t bytes = 0;
    std::string file_bytes;
    const auto write = [&](void* memory) {
        if (png_image_write_to_memory(&png, memory, &bytes, 0, values.data(), 0, nullptr) == 0)
            throw InputError(fmt::format("a PNG image cannot be made: {}", png.message));
    };
    write(nullptr); // how many bytes
    file_bytes.resize(bytes);
    write(file_bytes.data());
    file_bytes.resize(bytes);
    return file_bytes;
}

void write_png(const Image& image, const std::string& path) {
    OutputFile file(path);
    file.write(png_bytes(image));
    file.commit();
}

Image read_png(const std::string& path) {
    const MappedFile file(path);
    const auto fail = [&](const std::string& what) {
        return InputError(fmt::format("{}: not a readable PNG image: {}", path, what));
    };
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    const std::unique_ptr<png_image, void (*)(png_image*)> freed(&png, png_image_free);
    if (png_image_begin_read_from_memory(&png, file.bytes().data(), file.bytes().size()) == 0)
        throw fail(png.message);
    const bool colour = (png.format & PNG_FORMAT_FLAG_COLOR) != 0;
    Image image;
    image.width = png.width;
    image.height = png.height;
    image.channels =
        colour ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"Y"};
    const std::size_t channels = image.channels.size();
    try {
        check_image_size(image.width, image.height, channels, file.bytes().size());
    } catch (const InputError& e) {
        throw fail(e.what());
    }
    // At 8 bits libpng's own conversion to linear light is too coarse for dark values.
    const bool eight_bits = (png.format & PNG_FORMAT_FLAG_LINEAR) == 0;
    png.format =
        (colour ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY) | (eight_bits ? 0U : PNG_FORMAT_FLAG_LINEAR);
    std::vector<std::uint16_t> wide(eight_bits ? 0 : image.width * image.height * channels);
    std::vector<std::uint8_t> narrow(eight_bits ? image.width * image.height * channels : 0);
    // Over the buffer's zeros: black behind what is transparent.
    if (png_image_finish_read(&png, nullptr,
                              eight_bits ? static_cast<void*>(narrow.data()) : wide.data(), 0,
                              nullptr) == 0)
        throw fail(png.message);
    for (std::size_t ch = 0; ch < channels; ++ch) {
        std::vector<float>& plane = image.planes.emplace_back(image.width * image.height);
        for (std::size_t i = 0; i < plane.size(); ++i)
            plane[i] = eight_bits
                           ? linear_of_srgb(static_cast<float>(narrow[i * channels + ch]) / 255.0F)
                           : static_cast<float>(wide[i * channels + ch]) / 65535.0F;
    }
    return image;
}

Image read_image(const std::string& path) {
    const MappedFile file(path);
    if (starts_with(file.bytes(), png_signature))
        return read_png(path);
    if (starts_with(file.bytes(), exr_signature))
        return read_exr(path);
    throw InputError(fmt::format("{}: not an image; expected OpenEXR or PNG", path));
}

} // namespace brdfit

#include "host/image/jpeg.hpp"

#include "host/error.hpp"
#include "host/image/srgb.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gdk-pixbuf/gdk-pixbuf.h>
#include <memory>

namespace brdfit {

std::string jpeg_bytes(const Image& image) {
    constexpr const char* quality = "88"; // no squares to be seen
    const std::array<const std::vector<float>*, 3> planes{image.plane("R"), image.plane("G"),
                                                          image.plane("B")};
    if (std::any_of(planes.begin(), planes.end(), [](const auto* plane) { return !plane; }))
        throw UsageError("a picture without channel R, G or B; expected all of them");
    std::string values;
    values.reserve(3 * image.width * image.height);
    for (std::size_t i = 0; i < image.width * image.height; ++i)
        for (const std::vector<float>* plane : planes)
            values += static_cast<char>(
                static_cast<unsigned char>(std::lround(255 * srgb_of_linear((*plane)[i]))));
    const std::unique_ptr<GdkPixbuf, void (*)(gpointer)> pixels(
        gdk_pixbuf_new_from_data(reinterpret_cast<const guchar*>(values.data()), GDK_COLORSPACE_RGB,
                                 0, 8, static_cast<int>(image.width),
                                 static_cast<int>(image.height), static_cast<int>(3 * image.width),
                                 nullptr, nullptr),
        g_object_unref);
    gchar* bytes = nullptr;
    gsize size = 0;
    GError* error = nullptr;
    const bool made = gdk_pixbuf_save_to_buffer(pixels.get(), &bytes, &size, "jpeg", &error,
                                                "quality", quality, nullptr) != 0;
    const std::unique_ptr<gchar, void (*)(gpointer)> freed_bytes(bytes, g_free);
    const std::unique_ptr<GError, void (*)(GError*)> freed(error, g_error_free);
    if (!made)
        throw InputError(fmt::format("a JPEG image cannot be made: {}",
                                     error != nullptr ? error->message : "unknown"));
    return {bytes, size};
}

} // namespace brdfit

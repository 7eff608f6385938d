#include "host/image/svg.hpp"

#include "host/error.hpp"
#include "host/image/limits.hpp"
#include "host/image/srgb.hpp"

#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <librsvg/rsvg.h>
#include <memory>

namespace brdfit {

std::string svg_escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else if (static_cast<unsigned char>(c) < 0x20) // XML has none
            out += ' ';
        else
            out += c;
    return out;
}

std::string base64(const std::string& bytes) {
    constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k)
            word =
                word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? letters[word >> (18 - 6 * k) & 63U] : '=';
    }
    return out;
}

Image drawn_svg(const std::string& svg, std::size_t width, std::size_t height) {
    check_image_size(width, height, 4, width * height);
    GError* error = nullptr;
    const auto fail = [&](const char* what) {
        const std::unique_ptr<GError, void (*)(GError*)> freed(error, g_error_free);
        return InputError(
            fmt::format("a picture cannot be drawn: {}", error != nullptr ? error->message : what));
    };
    const auto* const bytes = reinterpret_cast<const guint8*>(svg.data());
    const std::unique_ptr<RsvgHandle, void (*)(gpointer)> handle(
        rsvg_handle_new_from_data(bytes, svg.size(), &error), g_object_unref);
    if (!handle)
        throw fail("no SVG");
    const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
        cairo_image_surface_create(CAIRO_FORMAT_ARGB32, static_cast<int>(width),
                                   static_cast<int>(height)),
        cairo_surface_destroy);
    const std::unique_ptr<cairo_t, void (*)(cairo_t*)> context(cairo_create(surface.get()),
                                                               cairo_destroy);
    const RsvgRectangle all{0, 0, static_cast<double>(width), static_cast<double>(height)};
    if (rsvg_handle_render_document(handle.get(), context.get(), &all, &error) == 0)
        throw fail("no picture");
    cairo_surface_flush(surface.get());
    if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS)
        throw fail("no memory");

    Image image;
    image.width = width;
    image.height = height;
    image.channels = {"R", "G", "B", "A"};
    image.planes.assign(4, std::vector<float>(width * height));
    const unsigned char* const data = cairo_image_surface_get_data(surface.get());
    const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(surface.get()));
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x) {
            std::uint32_t argb = 0; // of the machine's byte order, premultiplied
            std::memcpy(&argb, data + y * stride + 4 * x, sizeof argb);
            const float alpha = static_cast<float>(argb >> 24) / 255.0F;
            image.planes[3][y * width + x] = alpha;
            for (std::size_t ch = 0; ch < 3; ++ch) {
                const float value = static_cast<float>(argb >> (16 - 8 * ch) & 255U) / 255.0F;
                image.planes[ch][y * width + x] =
                    alpha > 0 ? alpha * linear_of_srgb(value / alpha) : 0;
            }
        }
    return image;
}

} // namespace brdfit

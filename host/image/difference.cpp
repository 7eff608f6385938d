#include "host/image/difference.hpp"

#include "host/error.hpp"
#include "host/image/srgb.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

void require_rgb_of_one_size(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height)
        throw UsageError(fmt::format("pictures of {} x {} and {} x {} pixels; expected one size",
                                     a.width, a.height, b.width, b.height));
    for (const Image* image : {&a, &b})
        for (const char* channel : {"R", "G", "B"})
            if (image->plane(channel) == nullptr)
                throw UsageError(
                    fmt::format("a picture without channel {}; expected R, G and B", channel));
}

Image difference(const Image& a, const Image& b, double scale) {
    require_rgb_of_one_size(a, b);
    Image made = a;
    for (std::size_t ch = 0; ch < made.planes.size(); ++ch)
        if (made.channels[ch] == "R" || made.channels[ch] == "G" || made.channels[ch] == "B") {
            const std::vector<float>& other = *b.plane(made.channels[ch]);
            for (std::size_t i = 0; i < other.size(); ++i)
                made.planes[ch][i] = static_cast<float>(
                    scale * std::abs(double{a.planes[ch][i]} - double{other[i]}));
        }
    return made;
}

Psnr psnr(const Image& a, const Image& b) {
    require_rgb_of_one_size(a, b);
    const auto decibels = [](double squares) {
        return squares > 0 ? -10 * std::log10(squares) : std::numeric_limits<double>::infinity();
    };
    Psnr made{};
    double all = 0;
    constexpr std::array<const char*, 3> channels{"R", "G", "B"};
    for (std::size_t ch = 0; ch < channels.size(); ++ch) {
        const std::vector<float>&x = *a.plane(channels[ch]), &y = *b.plane(channels[ch]);
        double squares = 0;
        for (std::size_t i = 0; i < x.size(); ++i)
            squares += std::pow(srgb_of_linear(x[i]) - srgb_of_linear(y[i]), 2);
        squares /= static_cast<double>(x.size());
        made.channels[ch] = decibels(squares);
        all += squares / 3;
    }
    made.all = decibels(all);
    return made;
}

} // namespace brdfit

#pragma once

#include "host/error.hpp"

#include <cstddef>
#include <fmt/format.h>

namespace brdfit {

inline constexpr std::size_t most_image_values = std::size_t{1} << 26;

/// Throws InputError where an image is empty, has more than most_image_values, or more than `bytes`
/// of compressed data can hold: a broken header must not make us allocate.
inline void check_image_size(std::size_t width, std::size_t height, std::size_t channels,
                             std::size_t bytes) {
    constexpr std::size_t most_values_a_byte = 10000; // DEFLATE holds 1032 bytes in one
    if (width == 0 || height == 0 || channels == 0)
        throw InputError(fmt::format("{} x {} pixels of {} channels; expected at least one value",
                                     width, height, channels));
    if (width > most_image_values || height > most_image_values / width ||
        channels > most_image_values / (width * height))
        throw InputError(fmt::format("{} x {} pixels of {} channels; expected at most {} values",
                                     width, height, channels, most_image_values));
    if (width * height * channels / most_values_a_byte > bytes)
        throw InputError(fmt::format("{} bytes cannot hold {} x {} pixels of {} channels", bytes,
                                     width, height, channels));
}

} // namespace brdfit

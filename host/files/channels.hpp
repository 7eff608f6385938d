#pragma once

#include <cstddef>
#include <string_view>

namespace brdfit {

/// The most channels that measurements and materials have.
inline constexpr std::size_t max_channels = 4096;

/// Whether a text can name a channel: names head columns of .csv files and stand in JSON.
bool is_channel_name(std::string_view name);
/// What that is, for messages.
inline constexpr const char* channel_name_expected =
    "a channel's name without commas, quotes, control characters or outer spaces, in UTF-8";

} // namespace brdfit

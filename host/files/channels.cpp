#include "host/files/channels.hpp"

#include "host/files/json.hpp"
#include "host/files/text.hpp"

#include <algorithm>

namespace brdfit {

bool is_channel_name(std::string_view name) {
    return !name.empty() && text::trim(name) == name && is_utf8(name) &&
           std::none_of(name.begin(), name.end(), [](unsigned char c) {
               return c < 0x20 || c == 0x7F || c == ',' || c == '"';
           });
}

} // namespace brdfit

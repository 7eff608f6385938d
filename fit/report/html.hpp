#pragma once

#include "host/files/json.hpp"
#include "host/image/svg.hpp"

#include <string>

namespace brdfit {

/// Text as it stands in HTML, whatever bytes it has: those that are no UTF-8 become U+FFFD.
inline std::string html(const std::string& text) {
    return svg_escaped(is_utf8(text) ? text : Json::parse(dumped(Json(text))).get<std::string>());
}

} // namespace brdfit

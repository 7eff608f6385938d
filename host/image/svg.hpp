#pragma once

#include <string>

namespace brdfit {

/// Text as it stands in SVG, whatever characters it has.
std::string svg_escaped(const std::string& text);

} // namespace brdfit

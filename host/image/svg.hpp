#pragma once

#include <string>

// Text in SVG and other XML.

namespace brdfit::svg {

/// Text as it stands between tags.
std::string escaped(const std::string& text);
/// Text as it stands in a comment of XML, which may hold no two hyphens.
std::string commented(std::string text);

} // namespace brdfit::svg

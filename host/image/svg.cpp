#include "host/image/svg.hpp"

#include <algorithm>

namespace brdfit::svg {

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
    return out;
}

std::string commented(std::string text) {
    std::replace(text.begin(), text.end(), '-', '_');
    return escaped(text);
}

} // namespace brdfit::svg

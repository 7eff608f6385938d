#include "host/files/text.hpp"

#include "host/error.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::text {

namespace {

constexpr std::string_view white = " \t\r\v\f";

} // namespace

Lines::Lines(std::string_view bytes, std::string path) : path_(std::move(path)), rest_(bytes) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (rest_.substr(0, byte_order_mark.size()) == byte_order_mark)
        rest_.remove_prefix(byte_order_mark.size());
}

bool Lines::next() {
    while (!rest_.empty()) {
        const std::string_view near = rest_.substr(0, most_bytes + 1);
        const std::size_t end = std::min(near.find('\n'), near.size());
        ++number_;
        if (end > most_bytes)
            fail(fmt::format("longer than {} bytes; expected lines of text", most_bytes));
        line_ = trim(near.substr(0, end));
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        if (!line_.empty() && line_[0] != '#')
            return true;
    }
    return false;
}

std::size_t Lines::ahead(const std::function<bool(std::string_view line)>& counts) const {
    std::size_t count = 0;
    try {
        for (Lines lines(*this); lines.next();)
            count += counts(lines.line()) ? 1 : 0;
    } catch (const InputError&) { // the reader's, once it is there
    }
    return count;
}

std::size_t Lines::rows_ahead(std::size_t fields) const {
    return ahead([=](std::string_view row) { return row.size() + 1 >= 2 * fields; });
}

void Lines::fail(const std::string& message) const {
    throw InputError(fmt::format("{}: line {}: {}", path_, number_, message));
}

void Lines::fail_file(const std::string& message) const {
    throw InputError(fmt::format("{}: {}", path_, message));
}

std::string_view trim(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(white);
    if (begin == std::string_view::npos)
        return {};
    return text.substr(begin, text.find_last_not_of(white) + 1 - begin);
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
    fields.clear();
    if (separator == ' ') {
        std::size_t begin = line.find_first_not_of(white);
        while (begin != std::string_view::npos) {
            const std::size_t end = std::min(line.find_first_of(white, begin), line.size());
            fields.push_back(line.substr(begin, end - begin));
            begin = line.find_first_not_of(white, end);
        }
        return;
    }
    while (true) {
        const std::size_t end = std::min(line.find(separator), line.size());
        fields.push_back(trim(line.substr(0, end)));
        if (end == line.size())
            return;
        line.remove_prefix(end + 1);
    }
}

std::string quoted(std::string_view text) {
    constexpr std::size_t longest = 40;
    std::string result = "'";
    for (const char c : text.substr(0, longest))
        result += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? '?' : c;
    return result + (text.size() > longest ? "...'" : "'");
}

double number(const Lines& lines, std::string_view column, std::string_view field) {
    std::string_view digits = field;
    // from_chars knows no plus sign
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-')
        digits.remove_prefix(1);
    const char* const end = digits.data() + digits.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(digits.data(), end, value);
    if (error != std::errc{} || stop != end || !std::isfinite(value))
        lines.fail(fmt::format("column {}: {}; expected a finite number", column, quoted(field)));
    return value;
}

std::size_t count(const Lines& lines, std::string_view what, std::string_view field) {
    const char* const end = field.data() + field.size();
    std::size_t value = 0;
    const auto [stop, error] = std::from_chars(field.data(), end, value);
    if (error != std::errc{} || stop != end)
        lines.fail(fmt::format("{}: {}; expected a whole number", what, quoted(field)));
    return value;
}

} // namespace brdfit::text

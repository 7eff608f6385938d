#include "host/files/npy.hpp"

#include "host/error.hpp"

#include <charconv>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <optional>
#include <vector>

namespace brdfit::npy {

namespace {

constexpr std::string_view magic = "\x93NUMPY";

/// Reads the header's text, a Python dictionary such as
/// {'descr': '<f4', 'fortran_order': False, 'shape': (3, 6), }. Throws InputError.
class Header {
  public:
    Header(const std::string& path, std::string_view text) : path_(path), rest_(text) {
        expect('{');
        while (!take('}')) {
            const std::string_view key = string();
            expect(':');
            if (key == "descr")
                type = string();
            else if (key == "fortran_order")
                fortran_order = boolean();
            else if (key == "shape")
                shape = tuple();
            else
                fail("unknown key");
            if (!take(',')) {
                expect('}');
                break;
            }
        }
        if (!type || !fortran_order || !shape)
            fail("expected descr, fortran_order and shape");
    }

    std::optional<std::string_view> type;
    std::optional<bool> fortran_order;
    std::optional<std::vector<std::size_t>> shape;

    [[noreturn]] void fail(std::string_view message) const {
        throw InputError(fmt::format("{}: .npy header: {}", path_, message));
    }

  private:
    void skip_white() {
        rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size()));
    }
    /// Whether the next character is `c`, which is then passed.
    bool take(char c) {
        skip_white();
        if (rest_.empty() || rest_[0] != c)
            return false;
        rest_.remove_prefix(1);
        return true;
    }
    void expect(char c) {
        if (!take(c))
            fail(fmt::format("expected '{}'", c));
    }
    std::string_view string() {
        skip_white();
        const char quote = rest_.empty() ? '\0' : rest_[0];
        const std::size_t end = rest_.find(quote, 1);
        if ((quote != '\'' && quote != '"') || end == rest_.npos)
            fail("expected a text in quotes");
        const std::string_view text = rest_.substr(1, end - 1);
        rest_.remove_prefix(end + 1);
        return text;
    }
    bool boolean() {
        skip_white();
        for (const std::string_view word : {"False", "True"})
            if (rest_.substr(0, word.size()) == word) {
                rest_.remove_prefix(word.size());
                return word == "True";
            }
        fail("expected True or False");
    }
    std::vector<std::size_t> tuple() {
        std::vector<std::size_t> numbers;
        expect('(');
        while (!take(')')) {
            skip_white();
            std::size_t number = 0;
            const auto [end, error] =
                std::from_chars(rest_.data(), rest_.data() + rest_.size(), number);
            if (error != std::errc{})
                fail("shape: expected a whole number");
            rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
            numbers.push_back(number);
            if (!take(',')) {
                expect(')');
                break;
            }
        }
        return numbers;
    }

    const std::string& path_;
    std::string_view rest_;
};

/// The header of an array's bytes and what follows it.
struct Parts {
    Header header;
    std::string_view data;
};

Parts parts_of(std::string_view bytes, const std::string& name) {
    const auto fail = [&](const std::string& message) {
        throw InputError(fmt::format("{}: .npy header: {}", name, message));
    };
    const auto byte = [&](std::size_t i) -> std::size_t {
        return static_cast<unsigned char>(bytes[i]);
    };
    if (!recognise(bytes))
        fail("expected an array that NumPy wrote");
    if (bytes.size() < 12)
        fail("the file ends inside it");
    const std::size_t version = byte(6);
    if (version < 1 || version > 3)
        fail(fmt::format("version {}; expected 1, 2 or 3", version));
    std::size_t length = byte(8) | byte(9) << 8;
    if (version > 1)
        length |= byte(10) << 16 | byte(11) << 24;
    const std::size_t begin = version == 1 ? 10 : 12;
    if (length > bytes.size() - begin)
        fail("the file ends inside it");
    Parts parts{Header(name, bytes.substr(begin, length)), bytes.substr(begin + length)};
    if (*parts.header.fortran_order)
        parts.header.fail("fortran_order is True; expected rows in C order");
    return parts;
}

/// Throws InputError unless `bytes` are those of so many values.
void require_values(const std::string& name, std::size_t bytes, std::size_t rows,
                    std::size_t columns, std::size_t value_bytes) {
    // Divide instead of multiplying: the shape may be anything.
    const std::size_t values = bytes / value_bytes;
    const bool whole =
        rows == 0 || columns == 0
            ? bytes == 0
            : bytes % value_bytes == 0 && values % columns == 0 && values / columns == rows;
    if (!whole)
        throw InputError(fmt::format("{}: {} bytes of data; expected {} x {} values of {} bytes",
                                     name, bytes, rows, columns, value_bytes));
}

constexpr std::size_t most_letters = 1024;

void append_utf8(std::string& text, std::uint32_t letter) {
    if (letter < 0x80) {
        text += static_cast<char>(letter);
        return;
    }
    const int more = letter < 0x800 ? 1 : letter < 0x10000 ? 2 : 3; // bytes
    constexpr std::uint32_t first[] = {0, 0xC0, 0xE0, 0xF0};
    text += static_cast<char>(first[more] | (letter >> 6 * more & 0x3F));
    for (int k = more - 1; k >= 0; --k)
        text += static_cast<char>(0x80 | (letter >> 6 * k & 0x3F));
}

/// The letters of a text that is UTF-8.
std::vector<std::uint32_t> letters_of(const std::string& text) {
    std::vector<std::uint32_t> letters;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80)
            letters.push_back(byte);
        else if (byte >= 0xC0) // what leads others
            letters.push_back(byte & (byte < 0xE0 ? 0x1FU : byte < 0xF0 ? 0x0FU : 0x07U));
        else if (!letters.empty())
            letters.back() = letters.back() << 6 | (byte & 0x3FU);
    }
    return letters;
}

} // namespace

double Array::at(std::size_t row, std::size_t column) const {
    const std::size_t i = row * columns + column;
    if (float64) {
        double value;
        std::memcpy(&value, data + i * sizeof value, sizeof value);
        return value;
    }
    float value;
    std::memcpy(&value, data + i * sizeof value, sizeof value);
    return value;
}

bool recognise(std::string_view bytes) {
    return bytes.substr(0, magic.size()) == magic;
}

Array read(const MappedFile& file) {
    return read(file.bytes(), file.path());
}

Array read(std::string_view bytes, const std::string& name, bool column) {
    const Parts parts = parts_of(bytes, name);
    const Header& header = parts.header;
    Array table;
    table.float64 = *header.type == "<f8";
    if (!table.float64 && *header.type != "<f4")
        header.fail("expected the type '<f4' or '<f8' (little-endian float)");
    const std::vector<std::size_t>& shape = *header.shape;
    if (shape.size() != 2 && !(column && shape.size() == 1))
        header.fail(
            fmt::format("{} dimensions; expected {}2", shape.size(), column ? "1 or " : ""));
    table.rows = shape[0];
    table.columns = shape.size() == 1 ? 1 : shape[1];
    table.data = parts.data.data();
    require_values(name, parts.data.size(), table.rows, table.columns,
                   table.float64 ? sizeof(double) : sizeof(float));
    return table;
}

std::vector<std::string> read_texts(std::string_view bytes, const std::string& name) {
    const Parts parts = parts_of(bytes, name);
    const Header& header = parts.header;
    const std::string_view type = *header.type;
    const bool wide = type.substr(0, 2) == "<U";
    std::size_t letters = 0;
    const auto [end, error] = std::from_chars(type.data() + std::min<std::size_t>(2, type.size()),
                                              type.data() + type.size(), letters);
    if ((!wide && type.substr(0, 2) != "|S") || error != std::errc{} ||
        end != type.data() + type.size() || letters == 0 || letters > most_letters)
        header.fail(
            fmt::format("expected texts of at most {} letters (type '<U' or '|S')", most_letters));
    if (header.shape->size() != 1)
        header.fail(fmt::format("{} dimensions; expected 1", header.shape->size()));
    const std::size_t count = (*header.shape)[0], bytes_each = wide ? 4 * letters : letters;
    require_values(name, parts.data.size(), count, 1, bytes_each);
    std::vector<std::string> texts;
    for (std::size_t k = 0; k < count; ++k) {
        const std::string_view from = parts.data.substr(k * bytes_each, bytes_each);
        std::string text;
        if (wide)
            for (std::size_t i = 0; i < letters; ++i) {
                std::uint32_t letter;
                std::memcpy(&letter, from.data() + 4 * i, sizeof letter);
                append_utf8(text, letter);
            }
        else
            text = from;
        text.erase(text.find_last_not_of('\0') + 1);
        texts.push_back(std::move(text));
    }
    return texts;
}

std::string texts(const std::vector<std::string>& texts) {
    std::vector<std::vector<std::uint32_t>> letters;
    std::size_t longest = 1;
    for (const std::string& text : texts) {
        letters.push_back(letters_of(text));
        longest = std::max(longest, letters.back().size());
    }
    std::string bytes = header({texts.size()}, fmt::format("<U{}", longest));
    for (std::vector<std::uint32_t>& text : letters) {
        text.resize(longest);
        bytes.append(reinterpret_cast<const char*>(text.data()), 4 * longest);
    }
    return bytes;
}

std::string header(std::size_t rows, std::size_t columns) {
    return header({rows, columns}, "<f4");
}

std::string header(const std::vector<std::size_t>& shape, const std::string& type) {
    std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                   type, fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
    // Spaces and a line end fill the header up to a multiple of 64 bytes.
    constexpr std::size_t before = magic.size() + 4;
    text.append(63 - (before + text.size()) % 64, ' ');
    text += '\n';
    std::string bytes(magic);
    bytes += {'\x01', '\x00', static_cast<char>(text.size() & 0xff),
              static_cast<char>(text.size() >> 8)};
    return bytes + text;
}

} // namespace brdfit::npy

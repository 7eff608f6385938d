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
    const std::string_view bytes = file.bytes();
    const auto fail = [&](const std::string& message) {
        throw InputError(fmt::format("{}: .npy header: {}", file.path(), message));
    };
    const auto byte = [&](std::size_t i) -> std::size_t {
        return static_cast<unsigned char>(bytes[i]);
    };
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

    const Header header(file.path(), bytes.substr(begin, length));
    Array table;
    table.float64 = *header.type == "<f8";
    if (!table.float64 && *header.type != "<f4")
        header.fail("expected the type '<f4' or '<f8' (little-endian float)");
    if (*header.fortran_order)
        header.fail("fortran_order is True; expected rows in C order");
    if (header.shape->size() != 2)
        header.fail(fmt::format("{} dimensions; expected 2", header.shape->size()));
    table.rows = (*header.shape)[0];
    table.columns = (*header.shape)[1];
    table.data = bytes.data() + begin + length;
    const std::size_t data_bytes = bytes.size() - begin - length;
    const std::size_t value_bytes = table.float64 ? sizeof(double) : sizeof(float);
    // Divide instead of multiplying: the shape may be anything.
    const std::size_t values = data_bytes / value_bytes;
    const bool whole = table.rows == 0 || table.columns == 0
                           ? data_bytes == 0
                           : data_bytes % value_bytes == 0 && values % table.columns == 0 &&
                                 values / table.columns == table.rows;
    if (!whole)
        throw InputError(fmt::format("{}: {} bytes of data; expected {} x {} values of {} bytes",
                                     file.path(), data_bytes, table.rows, table.columns,
                                     value_bytes));
    return table;
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

#pragma once

#include "host/files/file.hpp"

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace brdfit::text {

/// Walks through the lines of a text that hold something: blank lines and `#` comments are passed
/// over, and so are a byte order mark and carriage returns.
class Lines {
  public:
    explicit Lines(std::string_view bytes, std::string path = {});
    explicit Lines(const MappedFile& file) : Lines(file.bytes(), file.path()) {}

    /// Moves to the next line; returns false at the end of the text. Throws InputError for a line
    /// longer than most_bytes: binary data, say.
    bool next();
    /// How many of the lines that follow count, up to one that next() throws for.
    std::size_t ahead(const std::function<bool(std::string_view line)>& counts) const;
    /// How many of them have room for so many fields.
    std::size_t rows_ahead(std::size_t fields) const;
    /// The line, without white space at its ends.
    std::string_view line() const { return line_; }
    /// Throws InputError naming the file and the line.
    [[noreturn]] void fail(const std::string& message) const;
    /// Throws InputError naming the file.
    [[noreturn]] void fail_file(const std::string& message) const;

    static constexpr std::size_t most_bytes = std::size_t{1} << 24;

  private:
    std::string path_;
    std::string_view rest_, line_;
    std::size_t number_ = 0;
};

/// Text without white space at its ends.
std::string_view trim(std::string_view text);
/// The fields of a line: between separators, trimmed; for the separator ' ' words between white
/// space.
void split(std::string_view line, char separator, std::vector<std::string_view>& fields);
/// Text in quotes, shortened and without control characters, for messages.
std::string quoted(std::string_view text);

/// The finite number that the whole field is. Throws InputError naming file, line and column.
double number(const Lines& lines, std::string_view column, std::string_view field);
/// The non-negative integer that the whole field is. `what` names it in the InputError.
std::size_t count(const Lines& lines, std::string_view what, std::string_view field);

} // namespace brdfit::text

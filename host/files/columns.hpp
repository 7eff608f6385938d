#pragma once

#include "host/files/file.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

// Tables of named columns, as .csv and .npy.

namespace brdfit {

/// Writes rows of numbers, collected and passed on in large pieces; the file appears whole or not
/// at all (OutputFile).
class RowWriter {
  public:
    explicit RowWriter(const std::string& path) : file_(path) {}

    void bytes(std::string_view text) { buffer_.append(text.data(), text.data() + text.size()); }
    void raw(float value) { bytes({reinterpret_cast<const char*>(&value), sizeof value}); }
    /// Number as the shortest text that is read back the same, then `separator`.
    template <typename Number>
    void text(Number value, char separator) {
        fmt::format_to(std::back_inserter(buffer_), FMT_COMPILE("{}{}"), value, separator);
    }
    void end_row() {
        if (buffer_.size() >= 1 << 20)
            flush();
    }
    void commit() {
        flush();
        file_.commit();
    }

  private:
    void flush() {
        file_.write(buffer_.data(), buffer_.size());
        buffer_.clear();
    }
    OutputFile file_;
    fmt::memory_buffer buffer_;
};

/// The `# ` lines and the line of names that begin a .csv file.
std::string csv_head(const std::vector<std::string>& names,
                     const std::vector<std::string>& provenance);

/// Throws InputError, naming the path, where a .csv file with these columns could not be read back.
void require_csv_names(const std::string& path, const std::vector<std::string>& names);

/// Writes a table of named float columns as `.csv` (with `# ` provenance lines) or `.npy` (N, M)
/// float32. `columns[m]` holds N values. Throws UsageError for another ending.
void write_columns(const std::string& path, const std::vector<std::string>& names,
                   const std::vector<std::vector<float>>& columns,
                   const std::vector<std::string>& provenance = {});

} // namespace brdfit

#pragma once

#include "host/files/file.hpp"
#include "host/progress.hpp"

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

/// Throws UsageError unless the path ends in .csv or .npy.
void require_columns_ending(const std::string& path);

/// Writes a table of named float columns, row after row, as `.csv` (with `# ` provenance lines) or
/// `.npy` (N, M) float32. Throws UsageError for another ending.
class ColumnWriter {
  public:
    /// `rows`: N, all that will be written.
    ColumnWriter(const std::string& path, const std::vector<std::string>& names, std::size_t rows,
                 const std::vector<std::string>& provenance);

    /// The next value of the row, or the first of the next one.
    void value(float x) {
        const bool last = ++column_ == columns_;
        if (csv_)
            writer_.text(x, last ? '\n' : ',');
        else
            writer_.raw(x);
        if (last) {
            column_ = 0;
            writer_.end_row();
        }
    }
    void commit() { writer_.commit(); }

  private:
    bool csv_;
    std::size_t columns_, column_ = 0;
    RowWriter writer_;
};

/// The same of whole columns: `columns[m]` holds N values.
void write_columns(const std::string& path, const std::vector<std::string>& names,
                   const std::vector<std::vector<float>>& columns,
                   const std::vector<std::string>& provenance = {},
                   const ProgressFunction& progress = {});

} // namespace brdfit

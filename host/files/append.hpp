#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace brdfit {

/// Makes what was created, renamed or removed in a folder outlast a crash of the system. Throws
/// InputError.
void sync_folder(const std::string& folder);

/// A file that grows by whole pieces, each on the disk before the next, with one writer at a time.
class AppendFile {
  public:
    /// Opens the file, or creates it for good. Throws InputError naming the path where that cannot
    /// be, and where another process has it open so.
    explicit AppendFile(const std::string& path);
    ~AppendFile();
    AppendFile(const AppendFile&) = delete;
    AppendFile& operator=(const AppendFile&) = delete;

    std::uint64_t size() const { return size_; }
    /// Drops what comes after the first `size` bytes.
    void cut(std::uint64_t size);
    /// Adds the bytes, which outlast a crash of the system when it returns. Where that fails none
    /// of them stay, as far as the system lets them be removed, and InputError is thrown.
    void append(std::string_view bytes);

  private:
    [[noreturn]] void fail(const char* action, int error) const;
    std::string path_;
    int file_ = -1;
    std::uint64_t size_ = 0;
};

/// Whether another process has the file open as an AppendFile. False where there is no such file.
bool is_being_appended(const std::string& path);

} // namespace brdfit

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace brdfit {

/// The bytes of an existing file, mapped read-only.
/// Throws InputError naming the path when it is missing, a directory, unreadable or empty.
class MappedFile {
  public:
    explicit MappedFile(const std::string& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;

    std::string_view bytes() const { return {data_, size_}; }
    const std::string& path() const { return path_; }
    /// Throws InputError where another process has made the file shorter since it was opened; where
    /// replace_cut_page() handles that, what it cut off reads as zeros. For readers, when they are
    /// done.
    void require_whole() const;

  private:
    std::string path_;
    const char* data_ = nullptr;
    std::size_t size_ = 0;
};

/// For a program's handler of SIGBUS, which touching a page brings that another process has cut off
/// a mapped file: puts a page of zeros at the address. False where no MappedFile is there.
bool replace_cut_page(const void* address);

/// Whether a file that OutputFile replaces is among take_replaced_files().
enum class Replaced { Said, Unsaid };

/// A file that appears under its name only when it is whole: bytes go to a temporary file beside
/// it, commit() renames. Without commit() nothing stays behind.
/// Devices and pipes (/dev/stdout) are written to directly.
/// Throws InputError naming the path when it cannot be created, written or renamed.
class OutputFile {
  public:
    explicit OutputFile(const std::string& path);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    void write(const void* data, std::size_t bytes);
    void write(std::string_view text) { write(text.data(), text.size()); }
    /// `durable`: the file outlasts a crash of the system once this returns.
    void commit(bool durable = false, Replaced said = Replaced::Said);
    /// Where the bytes go until then, for libraries that write files by themselves, instead of
    /// write().
    const std::string& path_until_commit() const { return temporary_.empty() ? path_ : temporary_; }

  private:
    [[noreturn]] void fail(const char* action, int error);
    std::string path_, temporary_;
    std::FILE* file_ = nullptr;
    int slot_ = -1;
};

/// Removes the temporary files of every OutputFile now open: for the signal handler of a program
/// about to die, async-signal-safe.
void remove_open_temporaries();

/// The existing files that commit(Replaced::Said) has replaced since the last call, in order.
std::vector<std::string> take_replaced_files();

/// Creates a folder and its parents. Throws InputError when it cannot be made or written to.
void make_output_folder(const std::string& path);

/// SHA-256 of the bytes, 64 hexadecimal digits. Empty where `stop` became true meanwhile.
std::string sha256(std::string_view bytes, const std::atomic<bool>* stop = nullptr);

} // namespace brdfit

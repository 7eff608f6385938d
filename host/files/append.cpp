#include "host/files/append.hpp"

#include "host/error.hpp"
#include "host/files/kill_point.hpp"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace brdfit {

void sync_folder(const std::string& folder) {
    const int file =
        open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0)
        throw InputError(
            fmt::format("{}: cannot open the folder: {}", folder, std::strerror(errno)));
    kill_point();
    // A file system that cannot sync folders keeps their order itself.
    const int error = fsync(file) == 0 || errno == EINVAL ? 0 : errno;
    close(file);
    if (error != 0)
        throw InputError(
            fmt::format("{}: cannot sync the folder: {}", folder, std::strerror(error)));
}

namespace {

// Returns 0 or what is wrong. Whoever only asks, is_being_appended, has the lock for an instant.
int lock(int file) {
    for (int attempt = 0;; ++attempt) {
        if (flock(file, LOCK_EX | LOCK_NB) == 0)
            return 0;
        if (errno != EWOULDBLOCK || attempt == 10)
            return errno;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

} // namespace

AppendFile::AppendFile(const std::string& path) : path_(path) {
    file_ = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file_ < 0)
        throw InputError(fmt::format("{}: cannot write: {}", path, std::strerror(errno)));
    try {
        struct stat status {};
        if (fstat(file_, &status) != 0 || !S_ISREG(status.st_mode))
            throw InputError(
                fmt::format("{}: is no regular file; expected one to append to", path));
        if (const int error = lock(file_); error == EWOULDBLOCK)
            throw InputError(fmt::format("{}: another process is writing to it", path));
        else if (error != 0)
            fail("lock", error);
        // After the lock: whoever had it may have written meanwhile.
        if (fstat(file_, &status) != 0)
            fail("read", errno);
        size_ = static_cast<std::uint64_t>(status.st_size);
        if (size_ == 0)
            sync_folder(std::filesystem::path(path).parent_path().string());
    } catch (...) {
        close(file_);
        throw;
    }
}

AppendFile::~AppendFile() {
    close(file_);
}

void AppendFile::fail(const char* action, int error) const {
    throw InputError(fmt::format("{}: cannot {}: {}", path_, action, std::strerror(error)));
}

void AppendFile::cut(std::uint64_t size) {
    kill_point();
    if (ftruncate(file_, static_cast<off_t>(size)) != 0 || fdatasync(file_) != 0)
        fail("cut", errno);
    size_ = size;
}

void AppendFile::append(std::string_view bytes) {
    const bool dies = at_kill_point();
    std::string_view left = dies ? bytes.substr(0, bytes.size() / 2) : bytes;
    int error = 0;
    while (!left.empty() && error == 0) {
        const ssize_t written = write(file_, left.data(), left.size());
        if (written > 0)
            left.remove_prefix(static_cast<std::size_t>(written));
        else if (written == 0 || errno != EINTR)
            error = written == 0 ? EIO : errno;
    }
    if (dies)
        kill_here();
    kill_point();
    if (error == 0 && fdatasync(file_) != 0)
        error = errno;
    if (error != 0) {
        if (ftruncate(file_, static_cast<off_t>(size_)) != 0) {
            // then whoever reads it drops the torn end
        }
        fail("write", error);
    }
    size_ += bytes.size();
}

bool is_being_appended(const std::string& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return false;
    const bool held = flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    close(file);
    return held;
}

} // namespace brdfit

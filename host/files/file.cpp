#include "host/files/file.hpp"

#include "host/error.hpp"
#include "host/files/append.hpp"
#include "host/files/kill_point.hpp"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <openssl/evp.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace brdfit {

namespace {

// Paths of temporary files now open, where a signal handler can reach them without allocating.
constexpr int slots = 64;
constexpr std::size_t path_capacity = 4096;
char open_paths[slots][path_capacity];
std::atomic<int> slot_state[slots]; // 0 free, 1 being filled, 2 in use

int occupy_slot(const std::string& path) {
    if (path.size() >= path_capacity)
        return -1;
    for (int i = 0; i < slots; ++i) {
        int free = 0;
        if (slot_state[i].compare_exchange_strong(free, 1)) {
            std::memcpy(open_paths[i], path.c_str(), path.size() + 1);
            slot_state[i].store(2);
            return i;
        }
    }
    return -1;
}

void release_slot(int slot) {
    if (slot >= 0)
        slot_state[slot].store(0);
}

} // namespace

void remove_open_temporaries() {
    for (int i = 0; i < slots; ++i)
        if (slot_state[i].load() == 2)
            unlink(open_paths[i]);
}

namespace {

// Files now mapped, where a handler of SIGBUS can find them.
constexpr int most_mapped = 256;
struct Mapping {
    std::atomic<int> state; // 0 free, 1 being filled, 2 in use
    std::atomic<std::uintptr_t> begin, end;
    int file; // open as long as it is mapped
} mapped[most_mapped];

/// Keeps the open file; whether there is room for it.
bool enter_mapping(const void* data, std::size_t size, int file) {
    for (Mapping& mapping : mapped) {
        int free = 0;
        if (mapping.state.compare_exchange_strong(free, 1)) {
            mapping.begin = reinterpret_cast<std::uintptr_t>(data);
            mapping.end = reinterpret_cast<std::uintptr_t>(data) + size;
            mapping.file = file;
            mapping.state.store(2);
            return true;
        }
    }
    return false;
}

Mapping* mapping_of(const void* data) {
    for (Mapping& mapping : mapped)
        if (mapping.state.load() == 2 &&
            mapping.begin.load() == reinterpret_cast<std::uintptr_t>(data))
            return &mapping;
    return nullptr;
}

} // namespace

bool replace_cut_page(const void* address) {
    const auto at = reinterpret_cast<std::uintptr_t>(address);
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    for (const Mapping& file : mapped)
        if (file.state.load() == 2 && at >= file.begin.load() && at < file.end.load())
            return mmap(reinterpret_cast<void*>(at / page * page), page, PROT_READ,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) != MAP_FAILED;
    return false;
}

MappedFile::MappedFile(const std::string& path) : path_(path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0)
        throw InputError(fmt::format("{}: cannot open: {}", path, std::strerror(errno)));
    const auto fail = [&](const std::string& message) {
        close(file);
        throw InputError(fmt::format("{}: {}", path, message));
    };
    struct stat status {};
    if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode))
        fail(fmt::format("is {}; expected a regular file",
                         S_ISDIR(status.st_mode) ? "a directory" : "not a regular file"));
    size_ = static_cast<std::size_t>(status.st_size);
    if (size_ == 0)
        fail("the file is empty; expected data");
    void* data = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    if (data == MAP_FAILED)
        fail(fmt::format("cannot read: {}", std::strerror(errno)));
    data_ = static_cast<const char*>(data);
    if (!enter_mapping(data, size_, file))
        close(file);
}

MappedFile::~MappedFile() {
    if (Mapping* const mapping = mapping_of(data_)) {
        close(mapping->file);
        mapping->state.store(0);
    }
    munmap(const_cast<char*>(data_), size_);
}

void MappedFile::require_whole() const {
    const Mapping* const mapping = mapping_of(data_);
    struct stat status {};
    if (mapping != nullptr &&
        (fstat(mapping->file, &status) != 0 || static_cast<std::size_t>(status.st_size) < size_))
        throw InputError(fmt::format("{}: became shorter than {} bytes while it was read; expected "
                                     "no other process to write it",
                                     path_, size_));
}

namespace {

std::mutex replaced_mutex;
std::vector<std::string> replaced;

} // namespace

OutputFile::OutputFile(const std::string& path) : path_(path) {
    struct stat status {};
    const bool exists = stat(path.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode))
        throw InputError(fmt::format("{}: is a directory; expected a file to write", path));
    if (exists && !S_ISREG(status.st_mode)) {
        file_ = std::fopen(path.c_str(), "wb");
    } else {
        temporary_ = fmt::format("{}.part{}", path, getpid());
        slot_ = occupy_slot(temporary_);
        file_ = std::fopen(temporary_.c_str(), "wb");
    }
    if (file_ == nullptr) {
        const int error = errno;
        release_slot(slot_);
        throw InputError(fmt::format("{}: cannot write: {}", path, std::strerror(error)));
    }
}

OutputFile::~OutputFile() {
    if (file_ != nullptr)
        std::fclose(file_);
    if (!temporary_.empty())
        unlink(temporary_.c_str());
    release_slot(slot_);
}

void OutputFile::fail(const char* action, int error) {
    throw InputError(fmt::format("{}: cannot {}: {}", path_, action, std::strerror(error)));
}

void OutputFile::write(const void* data, std::size_t bytes) {
    kill_point();
    if (bytes != 0 && std::fwrite(data, 1, bytes, file_) != bytes)
        fail("write", errno);
}

void OutputFile::commit(bool durable, Replaced said) {
    std::FILE* const file = file_;
    file_ = nullptr;
    kill_point();
    const bool flushed =
        std::fflush(file) == 0 && (!durable || temporary_.empty() || fsync(fileno(file)) == 0);
    const int flush_error = errno;
    const bool closed = std::fclose(file) == 0;
    if (!flushed || !closed)
        fail("write", flushed ? errno : flush_error);
    if (temporary_.empty())
        return;
    const bool there = access(path_.c_str(), F_OK) == 0;
    kill_point();
    if (std::rename(temporary_.c_str(), path_.c_str()) != 0)
        fail("rename the finished file", errno);
    if (there && said == Replaced::Said) {
        const std::lock_guard<std::mutex> lock(replaced_mutex);
        replaced.push_back(path_);
    }
    temporary_.clear();
    release_slot(slot_);
    slot_ = -1;
    if (durable)
        sync_folder(std::filesystem::path(path_).parent_path().string());
}

std::vector<std::string> take_replaced_files() {
    const std::lock_guard<std::mutex> lock(replaced_mutex);
    return std::exchange(replaced, {});
}

void make_output_folder(const std::string& path) {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error)
        throw InputError(fmt::format("{}: cannot make the folder: {}", path, error.message()));
    if (!std::filesystem::is_directory(path, error))
        throw InputError(fmt::format("{}: is a file; expected a folder to write to", path));
    if (access(path.c_str(), W_OK | X_OK) != 0)
        throw InputError(
            fmt::format("{}: cannot write in this folder: {}", path, std::strerror(errno)));
}

std::string sha256(std::string_view bytes, const std::atomic<bool>* stop) {
    constexpr std::size_t piece = 1 << 20;
    const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> state(EVP_MD_CTX_new(),
                                                                   EVP_MD_CTX_free);
    bool good = state != nullptr && EVP_DigestInit_ex(state.get(), EVP_sha256(), nullptr) == 1;
    for (std::size_t at = 0; good && at < bytes.size(); at += piece) {
        if (stop != nullptr && *stop)
            return "";
        const std::string_view part = bytes.substr(at, piece);
        good = EVP_DigestUpdate(state.get(), part.data(), part.size()) == 1;
    }
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned length = 0;
    if (!good || EVP_DigestFinal_ex(state.get(), digest, &length) != 1)
        throw InputError("SHA-256 failed");
    std::string text;
    for (unsigned i = 0; i < length; ++i)
        text += fmt::format("{:02x}", digest[i]);
    return text;
}

} // namespace brdfit

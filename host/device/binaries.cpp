#include "host/device/binaries.hpp"

#include "host/device/cache.hpp"
#include "host/device/errors.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <mutex>
#include <spdlog/spdlog.h>
#include <string_view>
#include <sys/stat.h>
#include <utility>
#include <vector>

namespace brdfit {

namespace {

namespace fs = std::filesystem;

// What a file begins with; then the hash of its binary, a line feed and the binary.
constexpr std::string_view magic = "brdfit program 1\n";
constexpr std::size_t hash_digits = 64;
constexpr std::size_t header_bytes = magic.size() + hash_digits + 1;
constexpr const char* extension = ".clbin";

// The instructions that this processor has: a folder may be shared by machines.
std::string processor_flags() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("flags", 0) == 0 || line.rfind("Features", 0) == 0)
            return line;
    return "";
}

std::string path_of(const Device& device, const std::string& options, const std::string& text) {
    static const std::string flags = processor_flags();
    std::string key;
    for (const std::string* part : {&device.platform, &device.name, &device.vendor, &device.version,
                                    &device.driver, &flags, &options, &text})
        key += fmt::format("{}:{}\n", part->size(), *part);
    return fmt::format("{}/{}{}", binary_folder(), sha256(key), extension);
}

// The binary in a file; throws InputError where that is none of ours or damaged.
std::string_view binary_in(const MappedFile& file) {
    const std::string_view bytes = file.bytes();
    if (bytes.size() <= header_bytes || bytes.substr(0, magic.size()) != magic ||
        bytes.substr(magic.size(), hash_digits) != sha256(bytes.substr(header_bytes)))
        throw InputError(
            fmt::format("{}: damaged; expected a program kept by brdfit", file.path()));
    return bytes.substr(header_bytes);
}

struct Kept {
    fs::path path;
    std::uintmax_t bytes;
    fs::file_time_type used;
};

// Programs in the folder, those not finished included; empty where there is no folder.
std::vector<Kept> kept_files() {
    std::vector<Kept> files;
    std::error_code error;
    for (fs::directory_iterator entry(binary_folder(), error), end; !error && entry != end;
         entry.increment(error)) {
        std::error_code gone; // by another process
        if (entry->path().filename().string().find(extension) == std::string::npos ||
            !entry->is_regular_file(gone))
            continue;
        const Kept file{entry->path(), entry->file_size(gone), entry->last_write_time(gone)};
        if (!gone)
            files.push_back(file);
    }
    return files;
}

// Removes the oldest files until the rest is within the limit.
void forget_oldest() {
    std::vector<Kept> files = kept_files();
    std::uintmax_t bytes = 0;
    for (const Kept& file : files)
        bytes += file.bytes;
    std::sort(files.begin(), files.end(),
              [](const Kept& a, const Kept& b) { return a.used < b.used; });
    for (const Kept& file : files) {
        if (bytes <= most_binary_bytes)
            return;
        std::error_code ignored;
        fs::remove(file.path, ignored);
        bytes -= file.bytes;
    }
}

// Makes the folder, for its owner alone: what is in it is run.
void make_binary_folder() {
    const std::string folder = binary_folder();
    std::error_code error;
    const bool there = fs::exists(folder, error);
    make_output_folder(folder);
    if (!there)
        chmod(folder.c_str(), S_IRWXU);
}

} // namespace

std::string binary_folder() {
    if (const char* path = std::getenv("BRDFIT_CACHE"))
        return path;
    if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder != nullptr && *folder != 0)
        return fmt::format("{}/brdfit", folder);
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0)
        return fmt::format("{}/.cache/brdfit", home);
    return "";
}

bool keeps_binaries(const Device& device) {
    return !is_pocl(device.platform) && !binary_folder().empty();
}

std::optional<cl::Program> kept_program(const Device& device, const std::string& options,
                                        const std::string& text) {
    const std::string path = path_of(device, options, text);
    std::error_code error;
    if (!fs::exists(path, error))
        return std::nullopt;
    try {
        const MappedFile file(path);
        const std::string_view binary = binary_in(file);
        cl::Program program(device.context, {device.handle},
                            cl::Program::Binaries{{binary.begin(), binary.end()}});
        program.build(device.handle, options.c_str());
        fs::last_write_time(path, fs::file_time_type::clock::now(), error); // used
        return program;
    } catch (const std::exception& problem) { // of the file or of OpenCL
        spdlog::debug("{}; built anew", message_of(problem));
        return std::nullopt;
    }
}

void keep_program(const Device& device, const std::string& options, const std::string& text,
                  const cl::Program& program) {
    static std::mutex mutex; // threads may build the same program
    static bool warned = false;
    const std::lock_guard<std::mutex> lock(mutex);
    try {
        const cl::Program::Binaries binaries = program.getInfo<CL_PROGRAM_BINARIES>();
        if (binaries.size() != 1 || binaries.front().empty())
            return; // the driver has none
        const std::string_view binary(reinterpret_cast<const char*>(binaries.front().data()),
                                      binaries.front().size());
        make_binary_folder();
        OutputFile file(path_of(device, options, text));
        file.write(magic);
        file.write(sha256(binary) + "\n");
        file.write(binary);
        file.commit(false, Replaced::Unsaid);
        forget_oldest();
    } catch (const std::exception& problem) {
        if (!std::exchange(warned, true))
            spdlog::warn("built kernels are not kept: {}; set BRDFIT_CACHE to a folder that can be "
                         "written, or to nothing",
                         message_of(problem));
    }
}

KeptBinaries count_binaries() {
    KeptBinaries kept;
    for (const Kept& file : kept_files()) {
        ++kept.files;
        kept.bytes += file.bytes;
    }
    return kept;
}

KeptBinaries clear_binaries() {
    KeptBinaries removed;
    for (const Kept& file : kept_files()) {
        std::error_code error;
        fs::remove(file.path, error);
        if (error)
            throw InputError(
                fmt::format("{}: cannot remove: {}", file.path.string(), error.message()));
        ++removed.files;
        removed.bytes += file.bytes;
    }
    return removed;
}

} // namespace brdfit

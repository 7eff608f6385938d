#include "host/device/kernels.hpp"

#include "host/device/binaries.hpp"
#include "host/device/cache.hpp"
#include "host/device/errors.hpp"
#include "host/embedded.hpp"
#include "host/files/file.hpp"

#include <atomic>
#include <cstdlib>
#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <set>

namespace brdfit {

namespace {

constexpr const char* build_options = "-cl-std=CL1.2 -cl-mad-enable";

std::atomic<const char*> last_build_text{nullptr};

// Notes what a driver is asked for, should it crash.
void note_build(const Device& device, const std::string& what) {
    static std::mutex mutex;
    static std::set<std::string> texts; // which stay
    const std::string remedy =
        is_pocl(device.platform)
            ? fmt::format("kernels that PoCL keeps in '{}' may be damaged: remove that folder, or "
                          "name another in POCL_CACHE_DIR",
                          pocl_cache().folder)
            : "--device chooses another";
    const std::lock_guard<std::mutex> lock(mutex);
    last_build_text =
        texts
            .insert(fmt::format("last asked to build the kernels for {} on {} ({}, "
                                "driver {}); {}",
                                what, device.name, device.platform, device.driver, remedy))
            .first->c_str();
}

} // namespace

std::string kernel_source(const std::string& path) {
    if (const char* folder = std::getenv("BRDFIT_KERNELS"))
        return std::string(MappedFile(fmt::format("{}/{}", folder, path)).bytes());
    for (const EmbeddedFile* file = embedded_kernels; file->name != nullptr; ++file)
        if (path == file->name)
            return file->text;
    throw InputError(fmt::format("kernels/{}: not among the kernels built in", path));
}

std::string kernel_text(const std::string& path) {
    return fmt::format("#line 1 \"kernels/{}\"\n{}\n", path, kernel_source(path));
}

std::string kernel_texts(std::initializer_list<const char*> paths) {
    std::string text;
    for (const char* path : paths)
        text += kernel_text(path);
    return text;
}

std::string kernel_variant(const std::string& path,
                           std::initializer_list<std::pair<const char*, const char*>> macros) {
    std::string text;
    for (const auto& [name, value] : macros)
        text += fmt::format("#define {} {}\n", name, value);
    text += kernel_text(path);
    for (const auto& macro : macros)
        text += fmt::format("#undef {}\n", macro.first);
    return text;
}

cl::Program build_kernels(const Device& device, const std::string& text, const std::string& what) {
    const Form& form = device.form;
    const std::string whole =
        fmt::format("#define V {}\n#define LS {}\n#define BLOCK {}\n"
                    "#define CANDIDATES {}\n#define RUN {}\n",
                    form.vector_width, form.local_size, form.block / form.vector_width,
                    form.candidates, form.run()) +
        text;
    note_build(device, what);
    const bool kept = keeps_binaries(device);
    if (kept)
        if (std::optional<cl::Program> program = kept_program(device, build_options, whole))
            return *program;
    cl::Program program(device.context, whole);
    try {
        program.build(device.handle, build_options);
    } catch (const cl::Error&) {
        if (is_pocl(device.platform))
            if (const std::string problem = pocl_cache_problem(); !problem.empty())
                throw DeviceError(fmt::format("the kernels for {} do not build on {}: {}", what,
                                              device.name, problem));
        throw DeviceError(fmt::format("the kernels for {} do not build on {}:\n{}", what,
                                      device.name,
                                      program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device.handle)));
    }
    if (kept)
        keep_program(device, build_options, whole, program);
    return program;
}

const char* last_build() noexcept {
    return last_build_text;
}

cl::Program build_gram_program(const Device& device) {
    return build_kernels(
        device, kernel_texts({"base/common.cl", "passes/gram.h", "passes/gram.cl"}), "the search");
}

cl::Program build_peaks_program(const Device& device) {
    return build_kernels(
        device, kernel_texts({"base/common.cl", "passes/peaks.h", "passes/peaks.cl"}), "the peaks");
}

std::string kernel_hash() {
    std::string text;
    for (const EmbeddedFile* file = embedded_kernels; file->name != nullptr; ++file)
        text += std::string(file->name) + '\n' + kernel_source(file->name) + '\n';
    return sha256(text);
}

} // namespace brdfit

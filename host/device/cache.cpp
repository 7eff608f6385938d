#include "host/device/cache.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"

#include <cstdlib>
#include <fmt/format.h>

namespace brdfit {

PoclCache pocl_cache() {
    if (const char* const folder = std::getenv("POCL_CACHE_DIR"))
        return {folder, "POCL_CACHE_DIR"};
    if (const char* const folder = std::getenv("XDG_CACHE_HOME"); folder != nullptr && *folder != 0)
        return {fmt::format("{}/pocl/kcache", folder), "XDG_CACHE_HOME"};
    if (const char* const home = std::getenv("HOME"))
        return {fmt::format("{}/.cache/pocl/kcache", home), "HOME"};
    return {"/tmp/pocl/kcache", ""};
}

std::string pocl_cache_problem() {
    const auto [folder, variable] = pocl_cache();
    std::string problem = "it is no folder";
    if (!folder.empty()) {
        try {
            make_output_folder(folder);
            OutputFile probe(folder + "/brdfit");
            probe.write(std::string(std::size_t{1} << 16, '\0')); // full disks refuse it
            return "";
        } catch (const InputError& error) {
            problem = error.what();
        }
    }
    return fmt::format("the OpenCL driver PoCL cannot keep kernels in '{}'{}: {}; set "
                       "POCL_CACHE_DIR to a folder it can write to",
                       folder, variable.empty() ? "" : fmt::format(" (from {})", variable),
                       problem);
}

bool is_pocl(const std::string& platform) {
    return platform == "Portable Computing Language";
}

} // namespace brdfit

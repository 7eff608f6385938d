#pragma once

#include <string>

namespace brdfit {

/// The folder where PoCL keeps what it built, and the environment variable that says so (empty:
/// none does). Without it PoCL has no device and builds nothing.
struct PoclCache {
    std::string folder, variable;
};
PoclCache pocl_cache();

/// What hinders PoCL from keeping kernels in its folder, and what to do; empty where nothing does.
/// Makes the folder where it is missing, as PoCL would.
std::string pocl_cache_problem();

/// Whether that is the name of PoCL's platform.
bool is_pocl(const std::string& platform);

} // namespace brdfit

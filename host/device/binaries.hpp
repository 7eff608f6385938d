#pragma once

#include "host/device/device.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

// Built programs, kept between runs as the driver's binaries (CL_PROGRAM_BINARIES), one file each.
// A file is named by the hash of all that determines its program: platform, device, driver, the
// processor's instructions (drivers compile for the one they run on), options and text. It holds
// a hash of its bytes: one that is damaged, or that the driver no longer takes, is built anew and
// replaced.

namespace brdfit {

/// The folder: what BRDFIT_CACHE says, otherwise brdfit in $XDG_CACHE_HOME or ~/.cache. Empty (also
/// BRDFIT_CACHE): none, and nothing is kept.
std::string binary_folder();

/// The most bytes kept; the files unused for longest go first.
inline constexpr std::uintmax_t most_binary_bytes = std::uintmax_t{256} << 20;

/// Whether the device's programs are kept here: not where its driver keeps them itself, as fast.
bool keeps_binaries(const Device& device);

/// The program kept for these options and text, built; none where there is none that works.
std::optional<cl::Program> kept_program(const Device& device, const std::string& options,
                                        const std::string& text);
/// Keeps a built program, in place of an older one. Where it cannot, says so once, as a warning.
void keep_program(const Device& device, const std::string& options, const std::string& text,
                  const cl::Program& program);

/// How much is kept, by all versions of this program.
struct KeptBinaries {
    std::size_t files = 0;
    std::uintmax_t bytes = 0;
};
KeptBinaries count_binaries();
/// Removes what is kept; returns what that was. Throws InputError for what cannot be removed.
KeptBinaries clear_binaries();

} // namespace brdfit

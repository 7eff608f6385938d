#pragma once

#include "host/device/device.hpp"

#include <initializer_list>
#include <string>
#include <utility>

namespace brdfit {

/// Text of the kernel file (path below kernels/): from the folder that the environment variable
/// BRDFIT_KERNELS names, while developing, otherwise as built in.
/// Throws InputError for a file that is missing there.
std::string kernel_source(const std::string& path);
/// The same after a #line directive, so that build logs name the kernel file.
std::string kernel_text(const std::string& path);
/// Those of several files, one after the other.
std::string kernel_texts(std::initializer_list<const char*> paths);
/// The text of a file between the definitions of macros and their ends: one of the variants that
/// it has, {{"NAME", "basis_sums"}} say.
std::string kernel_variant(const std::string& path,
                           std::initializer_list<std::pair<const char*, const char*>> macros);
/// Builds a program: the macros of the device's form (V, LS, BLOCK, CANDIDATES, RUN), then the
/// text. Throws DeviceError with the build log; `what` says there what the kernels are for.
cl::Program build_kernels(const Device& device, const std::string& text, const std::string& what);

/// Where a crash is most likely from, for its message: the last program asked of a driver, which
/// may crash while it compiles, and what to do about it; a text that stays. Null where none was
/// asked for. For signal handlers.
const char* last_build() noexcept;

/// Builds passes/gram.cl.
cl::Program build_gram_program(const Device& device);
/// Builds passes/peaks.cl, which measures what a device does at most.
cl::Program build_peaks_program(const Device& device);

/// Hash of the sources of all kernels, those used while developing included.
std::string kernel_hash();

} // namespace brdfit

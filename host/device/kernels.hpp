#pragma once

#include "host/device/device.hpp"

#include <string>

namespace brdfit {

/// Text of the kernel file (path below kernels/): from the folder that the environment variable
/// BRDFIT_KERNELS names, while developing, otherwise as built in.
/// Throws InputError for a file that is missing there.
std::string kernel_source(const std::string& path);
/// The same after a #line directive, so that build logs name the kernel file.
std::string kernel_text(const std::string& path);
/// Builds a program: the macros of the device's form (V, LS, BLOCK, CANDIDATES, RUN), then the
/// text. Throws InputError with the build log; `what` says there what the kernels are for.
cl::Program build_kernels(const Device& device, const std::string& text, const std::string& what);

/// Builds passes/gram.cl.
cl::Program build_gram_program(const Device& device);
/// Builds passes/peaks.cl, which measures what a device does at most.
cl::Program build_peaks_program(const Device& device);

/// Hash of the sources of all kernels, those used while developing included.
std::string kernel_hash();

} // namespace brdfit

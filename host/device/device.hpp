#pragma once

#include <CL/opencl.hpp>
#include <cstddef>
#include <string>
#include <vector>

namespace brdfit {

/// How kernels are written for a device: vectors and one item a group on a CPU, scalars and many
/// items a group on a GPU. The macros of the same names in kernels/base/common.cl.
struct Form {
    int vector_width; ///< V: samples a work-item handles at once, a power of 2 up to 16
    int local_size;   ///< LS: work-items a group, a power of 2
    int block;        ///< samples a group, a multiple of V * LS
    int candidates;   ///< of a batched search that a work-item carries at once

    /// Vectors a work-item handles one after the other where there is nothing to sum (RUN): on a
    /// CPU enough to make starting a group cheap.
    int run() const { return local_size == 1 ? 64 : 1; }

    friend bool operator==(const Form& a, const Form& b) {
        return a.vector_width == b.vector_width && a.local_size == b.local_size &&
               a.block == b.block && a.candidates == b.candidates;
    }
};

/// An OpenCL device with its context and queue, and the limits the project minds.
struct Device {
    int index = 0; ///< in list_devices()
    std::string name, platform, vendor, version, driver;
    bool cpu = false;
    unsigned compute_units = 0;
    std::size_t max_group = 0, local_memory = 0, global_memory = 0, max_allocation = 0;
    Form form{};
    cl::Device handle;
    cl::Context context;
    cl::CommandQueue queue;
};

/// The form a device has where nothing else is asked for: one for CPUs, one for GPUs.
Form shipped_form(const Device& device);

/// Every OpenCL device, without context and queue, in its shipped form. Empty where there is none.
/// Throws InputError where there is none and why is known: a folder that PoCL cannot write to, say.
std::vector<Device> list_devices();
/// Index of the default in `devices`: the first GPU, otherwise the first device.
std::size_t default_device(const std::vector<Device>& devices);
/// The device chosen by `wish`: an index, a part of its name (any case), or empty for the default;
/// with context, queue and the form that BRDFIT_FORM asks for or, where that is not set or empty,
/// `brdfit tune` found for it. Throws InputError, naming the package to install, where there is no
/// device at all, UsageError listing the devices where none or several match, and where BRDFIT_FORM
/// is none for the device.
Device open_device(const std::string& wish = "");
/// The same, or all devices where the wish is "all".
std::vector<Device> open_devices(const std::string& wish);

} // namespace brdfit

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
    bool vectors = false;       ///< whether it is to run CPU forms
    unsigned compute_units = 0; ///< of a CPU at most its processors, however many it claims
    std::size_t max_group = 0, local_memory = 0, global_memory = 0, max_allocation = 0;
    Form form{};
    std::string form_reason; ///< why this form, for people; empty until it is opened
    std::string wrong;       ///< what it was found to compute wrongly, for people; see probe.hpp
    cl::Device handle;
    cl::Context context;
    cl::CommandQueue queue;
};

/// The form a device has where nothing else is asked for: one for `vectors`, one for scalars.
Form shipped_form(const Device& device);

/// Every OpenCL device, without context and queue, in its shipped form. Empty where there is none.
/// Throws InputError where there is none and why is known: a folder that PoCL cannot write to, say.
std::vector<Device> list_devices();
/// Index of the default in `devices`: the first GPU, otherwise the first device.
std::size_t default_device(const std::vector<Device>& devices);
/// Those of `devices` that a wish names: by index, or by a part of the name, the platform's or the
/// vendor's, in any case.
std::vector<std::size_t> matching_devices(const std::vector<Device>& devices,
                                          const std::string& wish);
/// The device that `wish` names, or for an empty one the default; with context and queue. Its form
/// is what BRDFIT_FORM asks for or, where that is not set or empty, what `brdfit tune` found for
/// it, otherwise the shipped one: of vectors for a CPU whose driver makes good code of them (see
/// probe.hpp), of scalars for all else. Where BRDFIT_UNITS is set, a sub-device of so many compute
/// units. Throws InputError, naming the package to install, where there is no device at all,
/// UsageError listing the devices where none or several match, and where BRDFIT_FORM or
/// BRDFIT_UNITS is none for the device.
Device open_device(const std::string& wish = "");
/// Whether the driver can split the device into sub-devices, as BRDFIT_UNITS asks for.
bool has_sub_devices(const Device& device);
/// Several devices: each of a list with commas, once, or all where the wish is "all". Of all, those
/// that do not open are left out with a warning, unless there is no other.
std::vector<Device> open_devices(const std::string& wish);

} // namespace brdfit

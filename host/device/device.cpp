#include "host/device/device.hpp"

#include "host/device/cache.hpp"
#include "host/device/errors.hpp"
#include "host/device/probe.hpp"
#include "host/device/tuning.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <spdlog/spdlog.h>
#include <sstream>
#include <thread>
#include <utility>

namespace brdfit {

namespace {

constexpr const char* none_found = "no OpenCL device found; install a driver, for the CPU the "
                                   "Debian package pocl-opencl-icd";

std::string trimmed(std::string text) {
    while (!text.empty() &&
           (text.back() == '\0' || std::isspace(static_cast<unsigned char>(text.back()))))
        text.pop_back();
    return text;
}

std::string lower_case(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

// What an environment variable says, or nullptr where it is not set or empty.
const char* wished(const char* variable) {
    const char* const text = std::getenv(variable);
    return text != nullptr && *text != 0 ? text : nullptr;
}

// The form that BRDFIT_FORM asks for, "V,LS,BLOCK[,CANDIDATES]": for trying a device's kernels on
// another. Throws UsageError where these do not fit together or the device.
Form parse_form(const char* text, const Device& device) {
    Form form{0, 0, 0, 2};
    char rest = 0;
    const int read = std::sscanf(text, "%d,%d,%d%c%d%c", &form.vector_width, &form.local_size,
                                 &form.block, &rest, &form.candidates, &rest);
    if ((read != 3 && (read != 5 || rest != ',')) || !is_possible(form, device))
        throw UsageError(fmt::format(
            "BRDFIT_FORM={}: expected V,LS,BLOCK[,CANDIDATES], the first two powers of 2 up to 16 "
            "and 1024, the third a multiple of both, and a group that {} can run",
            text, device.name));
    return form;
}

Device describe(int index, const cl::Platform& platform, const cl::Device& handle) {
    Device device;
    device.index = index;
    device.name = trimmed(handle.getInfo<CL_DEVICE_NAME>());
    device.platform = trimmed(platform.getInfo<CL_PLATFORM_NAME>());
    device.vendor = trimmed(handle.getInfo<CL_DEVICE_VENDOR>());
    device.version = trimmed(handle.getInfo<CL_DEVICE_VERSION>());
    device.driver = trimmed(handle.getInfo<CL_DRIVER_VERSION>());
    device.cpu = (handle.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_CPU) != 0;
    device.compute_units = handle.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
    const unsigned processors = std::thread::hardware_concurrency();
    if (device.cpu && processors > 0)
        device.compute_units = std::min(device.compute_units, processors);
    device.vectors = device.cpu;
    device.max_group = handle.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
    device.local_memory = static_cast<std::size_t>(handle.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>());
    device.global_memory = static_cast<std::size_t>(handle.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>());
    device.max_allocation =
        static_cast<std::size_t>(handle.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>());
    device.handle = handle;
    device.form = shipped_form(device);
    return device;
}

// Finds a platform's devices. Returns what hinders it where it has none, empty where it is unknown.
std::string find_devices(const cl::Platform& platform, std::vector<cl::Device>& handles) {
    std::string name, problem;
    try {
        name = trimmed(platform.getInfo<CL_PLATFORM_NAME>());
        if (!is_pocl(name) || !pocl_cache().folder.empty()) // PoCL would abort
            platform.getDevices(CL_DEVICE_TYPE_ALL, &handles);
    } catch (const cl::Error& error) {
        if (error.err() != CL_DEVICE_NOT_FOUND)
            problem = fmt::format("{}: {}", name, message_of(error));
    }
    if (handles.empty() && is_pocl(name))
        if (const std::string of_cache = pocl_cache_problem(); !of_cache.empty())
            problem = of_cache;
    return problem;
}

// Leaves of a device as many compute units as BRDFIT_UNITS asks for.
void split(Device& device, const char* text) {
    unsigned units = 0;
    char rest = 0;
    if (!has_sub_devices(device) || std::sscanf(text, "%u%c", &units, &rest) != 1 || units < 1 ||
        units > device.compute_units)
        throw UsageError(fmt::format(
            "BRDFIT_UNITS={}: {}", text,
            has_sub_devices(device)
                ? fmt::format("expected a number from 1 to {}, the compute units of {}",
                              device.compute_units, device.name)
                : fmt::format("the driver cannot split {} into sub-devices", device.name)));
    const cl_device_partition_property counts[] = {CL_DEVICE_PARTITION_BY_COUNTS, units,
                                                   CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    std::vector<cl::Device> parts;
    device.handle.createSubDevices(counts, &parts);
    device.handle = parts.at(0);
    device.compute_units = units;
}

// The form of an opened device and the reason for it.
void choose_form(Device& device) {
    if (const char* const text = wished("BRDFIT_FORM")) {
        device.form = parse_form(text, device);
        device.form_reason = "BRDFIT_FORM asks for it";
    } else if (const std::optional<TunedForm> tuned = tuned_form(device)) {
        device.form = tuned->form;
        device.vectors = tuned->form.vector_width > 1;
        device.form_reason = tuned->reason;
    } else {
        choose_shipped_form(device);
    }
}

Device opened(Device device) {
    try {
        if (const char* const units = wished("BRDFIT_UNITS"))
            split(device, units);
        device.context = cl::Context(device.handle);
        device.queue = cl::CommandQueue(device.context, device.handle);
    } catch (const cl::Error& error) {
        throw InputError(
            fmt::format("device {} ({}): {}", device.index, device.name, message_of(error)));
    }
    choose_form(device);
    return device;
}

std::string listing(const std::vector<Device>& devices, const std::vector<std::size_t>& which) {
    std::string text;
    for (const std::size_t i : which)
        text += fmt::format("{}{} {} ({}, {})", text.empty() ? "" : "; ", devices[i].index,
                            devices[i].name, devices[i].platform, devices[i].vendor);
    return text;
}

} // namespace

Form shipped_form(const Device& device) {
    if (device.vectors)
        return {16, 1, 2048, 4};
    // The largest power of 2 up to 128 that a group and its local memory can hold.
    int local = 128;
    while (local > 1 && (static_cast<std::size_t>(local) > device.max_group ||
                         static_cast<std::size_t>(local) * sizeof(float) > device.local_memory))
        local /= 2;
    return {1, local, 8192, 4};
}

std::vector<Device> list_devices() {
    std::vector<Device> devices;
    std::vector<cl::Platform> platforms;
    try {
        cl::Platform::get(&platforms);
    } catch (const cl::Error&) {
        return devices; // the loader knows no platform
    }
    std::string problem; // of a platform without devices
    for (const cl::Platform& platform : platforms) {
        std::vector<cl::Device> handles;
        if (const std::string found = find_devices(platform, handles); !found.empty())
            problem = found;
        for (const cl::Device& handle : handles)
            devices.push_back(describe(static_cast<int>(devices.size()), platform, handle));
    }
    if (devices.empty() && !problem.empty())
        throw InputError("no OpenCL device found: " + problem);
    if (!problem.empty())
        spdlog::warn("{}", problem);
    return devices;
}

std::size_t default_device(const std::vector<Device>& devices) {
    const auto gpu =
        std::find_if(devices.begin(), devices.end(), [](const Device& d) { return !d.cpu; });
    return gpu == devices.end() ? 0 : static_cast<std::size_t>(gpu - devices.begin());
}

std::vector<std::size_t> matching_devices(const std::vector<Device>& devices,
                                          const std::string& wish) {
    std::vector<std::size_t> matches;
    std::size_t index = 0;
    const char* const end = wish.data() + wish.size();
    const auto number = std::from_chars(wish.data(), end, index);
    if (number.ec == std::errc() && number.ptr == end) {
        if (index < devices.size())
            matches.push_back(index);
        return matches;
    }
    const std::string part = lower_case(wish);
    for (std::size_t i = 0; i < devices.size(); ++i)
        for (const std::string* of : {&devices[i].name, &devices[i].platform, &devices[i].vendor})
            if (lower_case(*of).find(part) != std::string::npos) {
                matches.push_back(i);
                break;
            }
    return matches;
}

bool has_sub_devices(const Device& device) {
    try {
        const auto ways = device.handle.getInfo<CL_DEVICE_PARTITION_PROPERTIES>();
        return std::find(ways.begin(), ways.end(), CL_DEVICE_PARTITION_BY_COUNTS) != ways.end();
    } catch (const cl::Error&) {
        return false; // a driver older than the standard
    }
}

Device open_device(const std::string& wish) {
    const std::vector<Device> devices = list_devices();
    if (devices.empty())
        throw InputError(none_found);
    if (wish.empty())
        return opened(devices[default_device(devices)]);
    const std::vector<std::size_t> matches = matching_devices(devices, wish);
    if (matches.size() > 1)
        throw UsageError(fmt::format("--device '{}' matches several devices: {}; choose one by its "
                                     "index",
                                     wish, listing(devices, matches)));
    if (matches.empty()) {
        std::vector<std::size_t> all(devices.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        throw UsageError(fmt::format("--device '{}' matches no devices; known: {}", wish,
                                     listing(devices, all)));
    }
    return opened(devices[matches.front()]);
}

std::vector<Device> open_devices(const std::string& wish) {
    std::vector<Device> devices;
    if (wish != "all") {
        std::string part;
        for (std::istringstream parts(wish + ','); std::getline(parts, part, ',');) {
            if (part.empty() && !wish.empty())
                throw UsageError(fmt::format("--device '{}': expected a device on both sides of "
                                             "each comma",
                                             wish));
            Device device = open_device(part);
            if (std::none_of(devices.begin(), devices.end(),
                             [&](const Device& d) { return d.index == device.index; }))
                devices.push_back(std::move(device));
        }
        return devices;
    }
    std::vector<std::string> problems;
    for (const Device& device : list_devices()) {
        try {
            devices.push_back(opened(device));
        } catch (const InputError& error) {
            problems.emplace_back(error.what());
        }
    }
    if (devices.empty())
        throw InputError(problems.empty() ? none_found : problems.front());
    for (const std::string& problem : problems)
        spdlog::warn("{}; left out", problem);
    return devices;
}

} // namespace brdfit

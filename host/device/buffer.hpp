#pragma once

#include "host/device/device.hpp"
#include "host/device/errors.hpp"

#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <vector>

namespace brdfit {

/// A device buffer of `bytes` (at least 1), of or with a copy of the host's memory where the flags
/// say so. Throws DeviceError when it is larger than the device allows.
inline cl::Buffer make_buffer(const Device& device, std::size_t bytes,
                              cl_mem_flags flags = CL_MEM_READ_WRITE, void* host = nullptr) {
    if (bytes > device.max_allocation)
        throw DeviceError(fmt::format("{} needs a buffer of {} MiB; its limit is {} MiB",
                                      device.name, bytes >> 20, device.max_allocation >> 20));
    return cl::Buffer(device.context, flags, bytes == 0 ? 1 : bytes, host);
}

/// A device buffer with a copy of the host's data.
template <typename T>
cl::Buffer upload(const Device& device, const std::vector<T>& data) {
    cl::Buffer buffer = make_buffer(device, data.size() * sizeof(T), CL_MEM_READ_ONLY);
    if (!data.empty())
        device.queue.enqueueWriteBuffer(buffer, CL_TRUE, 0, data.size() * sizeof(T), data.data());
    return buffer;
}

/// Asks the system for large pages behind a CPU's buffer that kernels will read here and there: of
/// small ones the processor keeps too few addresses. Before anything is written to it.
void prefer_large_pages(const Device& device, const cl::Buffer& buffer, std::size_t bytes);

/// Copies `count` values from the start of a device buffer.
template <typename T>
std::vector<T> download(const Device& device, const cl::Buffer& buffer, std::size_t count) {
    std::vector<T> data(count);
    if (count != 0)
        device.queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(T), data.data());
    return data;
}

/// The least multiple of `step` that is at least `count`.
inline std::size_t padded(std::size_t count, std::size_t step) {
    return (count + step - 1) / step * step;
}

/// Enqueues a kernel whose work-items handle runs (FOR_EACH_OF_RUN of kernels/base/common.cl) of
/// `count` vectors, for each of `rows`.
inline void enqueue_runs(const Device& device, cl::Kernel& kernel, std::size_t count,
                         std::size_t rows = 1) {
    const auto local = static_cast<std::size_t>(device.form.local_size);
    const auto run = static_cast<std::size_t>(device.form.run());
    device.queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                                      cl::NDRange(padded((count + run - 1) / run, local), rows),
                                      cl::NDRange(local, 1));
}

/// theta or coefficients in the device's precision.
inline std::vector<float> to_float(const std::vector<double>& values) {
    return {values.begin(), values.end()};
}

} // namespace brdfit

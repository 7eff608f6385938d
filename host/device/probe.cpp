#include "host/device/probe.hpp"

#include "host/device/buffer.hpp"
#include "host/device/cache.hpp"
#include "host/device/errors.hpp"
#include "host/device/kernels.hpp"
#include "host/device/tuning.hpp"
#include "host/error.hpp"
#include "kernels/passes/peaks.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <limits>
#include <spdlog/spdlog.h>

namespace brdfit {

namespace {

constexpr std::size_t lanes = 8192; // of all work-items together
constexpr int rounds = 64;
constexpr int runs = 6; // the first may compile
// Vectors, which need no barriers, unless scalars are this much faster: a driver either makes
// vector instructions of vectors or runs their lanes one by one.
constexpr double clearly = 2;

Device in_form(Device device, bool vectors) {
    device.vectors = vectors;
    device.form = shipped_form(device);
    return device;
}

// Calls of exp a second in the device's form; the best of several runs.
double exp_per_second(const Device& device) {
    const auto local = static_cast<std::size_t>(device.form.local_size);
    const std::size_t items = lanes / static_cast<std::size_t>(device.form.vector_width);
    cl::Kernel kernel(build_peaks_program(device), "exp_calls");
    const cl::Buffer out = make_buffer(device, items / local * sizeof(float), CL_MEM_WRITE_ONLY);
    kernel.setArg(0, static_cast<cl_int>(rounds));
    kernel.setArg(1, out);
    double best = std::numeric_limits<double>::infinity();
    for (int run = 0; run < runs; ++run) {
        using Clock = std::chrono::steady_clock;
        const auto started = Clock::now();
        device.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items),
                                          cl::NDRange(local));
        device.queue.finish();
        best = std::min(best, std::chrono::duration<double>(Clock::now() - started).count());
    }
    return static_cast<double>(lanes) * rounds * double{CHAINS} / best;
}

} // namespace

void choose_shipped_form(Device& device) {
    if (!device.cpu || is_pocl(device.platform)) {
        device.form_reason = device.cpu ? "PoCL makes good code of vectors"
                                        : "no CPU: many work-items a group, of scalars";
        return;
    }
    try {
        const double scalars = exp_per_second(in_form(device, false));
        const double vectors = exp_per_second(in_form(device, true));
        device = in_form(device, clearly * vectors > scalars);
        device.form_reason =
            fmt::format("a probe: {:.2f} G exp/s in vectors of 16, {:.2f} in scalars",
                        vectors / 1e9, scalars / 1e9);
    } catch (const std::exception& error) { // of OpenCL, or of a build
        device = in_form(device, false);
        device.form_reason = "the probe failed: " + message_of(error);
        return;
    }
    try {
        if (!tuning_path().empty())
            store_tuned_form(device, device.form, device.form_reason);
    } catch (const InputError& error) {
        spdlog::debug("the form is not kept: {}", error.what());
    }
}

} // namespace brdfit

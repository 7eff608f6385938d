#include "host/device/probe.hpp"

#include "host/device/buffer.hpp"
#include "host/device/cache.hpp"
#include "host/device/errors.hpp"
#include "host/device/kernels.hpp"
#include "host/device/tuning.hpp"
#include "host/error.hpp"
#include "kernels/passes/answers.h"
#include "kernels/passes/peaks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <spdlog/spdlog.h>
#include <string>
#include <vector>

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

// Vectors or scalars, by what the driver makes of them, and the reason.
void choose_by_speed(Device& device) {
    if (!device.cpu) {
        device.form_reason = "no CPU: many work-items a group, of scalars";
        return;
    }
    const double scalars = exp_per_second(in_form(device, false));
    const double vectors = exp_per_second(in_form(device, true));
    device = in_form(device, clearly * vectors > scalars);
    device.form_reason = fmt::format("a probe: {:.2f} G exp/s in vectors of 16, {:.2f} in scalars",
                                     vectors / 1e9, scalars / 1e9);
}

const char* name_of_form(const Device& device) {
    return device.vectors ? "vectors of 16" : "scalars";
}

// Leaves a form whose answers are wrong for one whose answers are right, where there is one.
void choose_by_answers(Device& device) {
    device.wrong = wrong_answers(device);
    if (device.wrong.empty() || !device.cpu)
        return;
    Device other = in_form(device, !device.vectors);
    if (!wrong_answers(other).empty())
        return;
    other.form_reason = fmt::format("wrong answers in {}: {}", name_of_form(device), device.wrong);
    other.wrong.clear();
    spdlog::warn("device {} ({}): {}; {} are used", device.index, device.name, other.form_reason,
                 name_of_form(other));
    device = other;
}

// Where f of an argument is what it is in float64, up to the rounding that OpenCL allows.
struct Known {
    const char* name;
    double (*f)(double x);
};
constexpr Known known[ANSWERS] = {
    {"exp", [](double x) { return std::exp(-x); }},
    {"log", [](double x) { return std::log(x); }},
    {"sqrt", [](double x) { return std::sqrt(x); }},
    {"rsqrt", [](double x) { return 1 / std::sqrt(x); }},
    {"sin", [](double x) { return std::sin(x); }},
    {"cos", [](double x) { return std::cos(x); }},
    {"atan2", [](double x) { return std::atan2(x, 2 - x); }},
    {"a choice", [](double x) { return x > 1 ? std::min(x, 3.0) : std::max(x * x, 0.5); }}};
constexpr double answer_tolerance = 1e-5; // of the value, and of 0.1 where that is more

bool is_right(double answer, double value) {
    return std::abs(answer - value) <= answer_tolerance * std::max(std::abs(value), 0.1);
}

} // namespace

std::string wrong_answers(const Device& device) {
    const auto width = static_cast<std::size_t>(device.form.vector_width);
    const auto local = static_cast<std::size_t>(device.form.local_size);
    const auto run = static_cast<std::size_t>(device.form.run());
    const std::size_t vectors = lanes / width, groups = vectors / run / local;
    std::vector<float> x(lanes);
    for (std::size_t i = 0; i < lanes; ++i) // 0.003 to 20, close together and far from it
        x[i] = 0.003F * std::exp(8.8F * static_cast<float>(i * 37 % lanes) / lanes);
    cl::Kernel kernel(
        build_kernels(device,
                      kernel_texts({"base/common.cl", "passes/answers.h", "passes/answers.cl"}),
                      "the probe"),
        "answers");
    const cl::Buffer in = upload(device, x);
    const cl::Buffer out = make_buffer(device, ANSWERS * lanes * sizeof(float));
    const cl::Buffer sums = make_buffer(device, groups * sizeof(float));
    kernel.setArg(0, in);
    kernel.setArg(1, static_cast<cl_uint>(vectors));
    kernel.setArg(2, out);
    kernel.setArg(3, sums);
    enqueue_runs(device, kernel, vectors);
    const std::vector<float> answers = download<float>(device, out, ANSWERS * lanes);
    for (std::size_t k = 0; k < ANSWERS; ++k)
        for (std::size_t i = 0; i < lanes; ++i) {
            const double answer = answers[k * lanes + i], value = known[k].f(x[i]);
            if (!is_right(answer, value))
                return fmt::format("{} at {:.6g} is {:.6g}, expected {:.6g}", known[k].name, x[i],
                                   answer, value);
        }
    const std::vector<float> sum = download<float>(device, sums, groups);
    const std::size_t group = lanes / groups;
    for (std::size_t g = 0; g < groups; ++g) {
        double value = 0;
        for (std::size_t i = g * group; i < (g + 1) * group; ++i)
            value += known[0].f(x[i]);
        if (!is_right(sum[g], value))
            return fmt::format("the sum over group {} is {:.6g}, expected {:.6g}", g, sum[g],
                               value);
    }
    return "";
}

void choose_shipped_form(Device& device) {
    if (device.cpu && is_pocl(device.platform)) {
        device.form_reason = "PoCL makes good code of vectors";
        return;
    }
    try {
        choose_by_speed(device);
        choose_by_answers(device);
    } catch (const std::exception& error) { // of OpenCL, or of a build
        device = in_form(device, false);
        device.form_reason = "the probe failed: " + message_of(error);
        return;
    }
    try {
        if (device.wrong.empty() && !tuning_path().empty())
            store_tuned_form(device, device.form, device.form_reason);
    } catch (const InputError& error) {
        spdlog::debug("the form is not kept: {}", error.what());
    }
}

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

} // namespace brdfit

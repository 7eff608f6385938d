#include "fit/devices.hpp"

#include "host/device/errors.hpp"
#include "host/device/probe.hpp"
#include "host/model/material.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <spdlog/spdlog.h>
#include <string>
#include <utility>

namespace brdfit {

double cost_of(const Structure& structure, Metric metric) {
    // As measured: a lobe more takes several times as long, and so do losses that are not
    // quadratic.
    constexpr double by_lobes[] = {0.1, 1, 6, 12, 20};
    return by_lobes[std::min<std::size_t>(structure.lobes.size(), max_lobes)] *
           (quadratic(metric) ? 1 : 4);
}

// One waits for the device while another is at work on the host.
std::size_t fits_at_once(const Device& device) {
    if (device.platform == "Oclgrind") // a simulator that takes calls of one thread alone
        return 1;
    return device.cpu ? std::max<std::size_t>(device.compute_units, 1) + 1 : 3;
}

FitDevice::FitDevice(Device opened)
    : device(std::move(opened)), at_once(fits_at_once(device)), programs(device) {}

FitDevices::FitDevices(std::vector<Device> devices) {
    std::vector<std::string> problems;
    for (Device& device : devices) {
        double expected = 1;
        try {
            if (!device.wrong.empty())
                throw DeviceError("its driver computes wrong values: " + device.wrong);
            if (devices.size() > 1)
                expected = exp_per_second(device);
        } catch (const std::exception& error) { // of OpenCL, or of a build
            problems.push_back(
                fmt::format("device {} ({}): {}", device.index, device.name, message_of(error)));
            continue;
        }
        devices_.push_back(std::make_unique<FitDevice>(std::move(device)));
        speeds_.push_back({expected});
    }
    if (devices_.empty())
        throw DeviceError(problems.at(0));
    for (const std::string& problem : problems)
        spdlog::warn("{}; left out", problem);
}

void FitDevices::took(std::size_t device, double cost, double seconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    speeds_[device].cost += cost;
    speeds_[device].seconds += seconds;
}

std::vector<double> FitDevices::paces() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<double> paces(size());
    double expected = 0, measured = 0; // of all that are measured
    for (std::size_t d = 0; d < size(); ++d) {
        paces[d] = static_cast<double>(devices_[d]->at_once) / speeds_[d].expected;
        if (speeds_[d].cost > 0) {
            expected += paces[d];
            measured += speeds_[d].seconds / speeds_[d].cost;
        }
    }
    for (std::size_t d = 0; d < size(); ++d)
        if (speeds_[d].cost > 0)
            paces[d] = speeds_[d].seconds / speeds_[d].cost;
        else if (expected > 0)
            paces[d] *= measured / expected;
    return paces;
}

bool FitDevices::pays(std::size_t device, double cost, double left,
                      const std::vector<bool>& at_work, double share) const {
    const std::vector<double> pace = paces();
    const auto seconds = [&](std::size_t d) {
        return cost * pace[d] / std::max(1.0, share * static_cast<double>(devices_[d]->at_once));
    };
    double alone = std::numeric_limits<double>::infinity(), together = 0;
    for (std::size_t d = 0; d < size(); ++d)
        if (d != device && at_work[d]) {
            alone = std::min(alone, seconds(d));
            together += static_cast<double>(devices_[d]->at_once) / pace[d];
        }
    return seconds(device) <= std::max(alone, left / together);
}

} // namespace brdfit

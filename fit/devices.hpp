#pragma once

#include "fit/metric.hpp"
#include "fit/programs.hpp"
#include "host/device/device.hpp"
#include "host/model/structure.hpp"

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace brdfit {

/// About what a fit costs, in fits of one lobe by a quadratic metric.
double cost_of(const Structure& structure, Metric metric);

/// Fits at once that keep the device and the host busy.
std::size_t fits_at_once(const Device& device);

/// A device that fits are made on, and the programs built for it.
struct FitDevice {
    explicit FitDevice(Device opened);
    FitDevice(const FitDevice&) = delete;
    FitDevice& operator=(const FitDevice&) = delete;

    const Device device;
    const std::size_t at_once; ///< fits_at_once(device)
    ProgramCache programs;
};

/// Devices that share fits, each of which takes what pays on it. Safe to use by several threads.
class FitDevices {
  public:
    /// Of several, each is asked first how fast it is, in some milliseconds; then what their fits
    /// took counts. One that fails at that, or that computes wrong values (Device::wrong), is left
    /// out with a warning. Throws DeviceError where none is left.
    explicit FitDevices(std::vector<Device> devices);
    std::size_t size() const { return devices_.size(); }
    FitDevice& operator[](std::size_t device) { return *devices_[device]; }

    /// What a fit of that cost took on a device that was busy with as many as it can.
    void took(std::size_t device, double cost, double seconds);

    /// Whether a device is to begin work of a cost: not where the others `at_work` would sooner
    /// have done all that is left, this included. The fastest is to in any case. `share`: of each
    /// device's fits at once, how much of it they work on; 0: one.
    bool pays(std::size_t device, double cost, double left, const std::vector<bool>& at_work,
              double share) const;

  private:
    // As measured, or as expected where nothing is: seconds that a fit takes for a cost of 1.
    std::vector<double> paces() const;

    struct Speed {
        double expected = 0; // of the whole device, beside the others'
        double cost = 0, seconds = 0;
    };
    std::vector<std::unique_ptr<FitDevice>> devices_;
    std::vector<Speed> speeds_;
    mutable std::mutex mutex_; // of speeds_
};

} // namespace brdfit

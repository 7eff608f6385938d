#pragma once

#include "host/device/device.hpp"
#include "host/progress.hpp"

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <nanobind/nanobind.h>
#include <stdexcept>
#include <string>

// How calls from Python reach the library: on which device, with the interpreter's lock released,
// interruptible, telling how far they are.

namespace brdfit::python {

namespace nb = nanobind;

/// No OpenCL device, or one that fails.
struct DeviceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The device of a wish (see open_device), opened once and never closed: materials of any thread
/// may use it until the process ends. Throws DeviceError where there is none, and in a process
/// forked from one that has opened a device: OpenCL's threads are not in the child.
const Device& opened(const std::string& wish);
/// Every device, as list_devices(). Throws like opened().
std::vector<Device> known_devices();

/// A call that is under way, as the work sees it.
class Call {
  public:
    /// Thrown out of work by progress() once the caller wants it no more.
    struct Interrupted : std::runtime_error {
        Interrupted() : std::runtime_error("interrupted") {}
    };

    /// For the work to tell its share; throws Interrupted once stopped.
    ProgressFunction progress() {
        return [this](double share) {
            if (stopped_)
                throw Interrupted();
            share_ = share;
        };
    }
    /// Says what is being done, and the share of all that is done by now.
    void say(double share, const std::string& what);
    bool stopped() const { return stopped_; }

  private:
    friend void watch(Call& call, const nb::object& progress,
                      const std::function<bool(std::chrono::milliseconds)>& ended);
    std::atomic<bool> stopped_{false};
    std::atomic<double> share_{0};
    std::mutex mutex_;
    std::string what_; // of mutex_
};

/// Until `ended` says so: releases the interpreter's lock, looks for signals (Ctrl-C) and calls
/// progress(share, what), where it is not None. Stops the call at a signal or an exception of
/// `progress`, and throws that once the call has ended, or what the user's filters make of a
/// warning.
void watch(Call& call, const nb::object& progress,
           const std::function<bool(std::chrono::milliseconds)>& ended);

/// Does work(call) on a thread of its own; returns what it returns.
template <typename Work>
auto run(const nb::object& progress, Work work) {
    Call call;
    auto result = std::async(std::launch::async, [&] { return work(call); });
    watch(call, progress, [&](std::chrono::milliseconds wait) {
        return result.wait_for(wait) == std::future_status::ready;
    });
    return result.get();
}

/// Makes Python warnings of what the library warns of, at the end of each run().
void collect_warnings();

/// Makes Python exceptions of the library's: InputError and UsageError become the package's
/// InputError, DeviceError and OpenCL's errors its DeviceError (use_errors in Python says which
/// classes they are), lack of memory MemoryError.
void translate_errors(nb::module_& module);

} // namespace brdfit::python

#pragma once

#include "fit/devices.hpp"
#include "fit/fit.hpp"

#include <exception>
#include <functional>
#include <optional>
#include <vector>

namespace brdfit {

/// One of several fits to a file: its result, or what it failed with.
struct FitOutcome {
    std::size_t index;              ///< of its structure
    const Device* device = nullptr; ///< that made it
    std::optional<FitResult> result;
    std::exception_ptr failure;
};

/// What is told of fits to a file. `next` and `done` are never called by two threads at once;
/// what they throw comes out of fit_all, after the fits under way.
struct FitCalls {
    /// A fit begins, by its index: for its progress. Twice for one that a device failed at.
    std::function<ProgressFunction(std::size_t index)> next;
    std::function<void(FitOutcome)> done;
    std::function<bool()> stop; ///< whether no further fit is to be begun; asked at any time
};

/// Who makes the fits to a file.
struct FitPlace {
    std::optional<std::size_t> home; ///< of the devices, this one alone, unless it fails; none: all
    std::size_t jobs = 1;            ///< files fitted to at once, which share what a device can do
    std::size_t at_once = 0;         ///< fits of a device; 0: as many as keep it busy
    /// By device, the file's samples as earlier calls with the same max_theta packed them, which
    /// this one then takes, or fills in; null: packs anew.
    std::vector<std::optional<DeviceSamples>>* packed = nullptr;
};

/// Fits structures to one file's samples, several at once and on several devices: each takes the
/// next where that pays on it. On one device results are the same to the bit, but for their
/// seconds, whatever is made at once; those of unlike devices agree to 1e-5 of their errors. A
/// device that fails at the file or at a fit leaves the rest to the others, with a warning. Returns
/// what hinders the fits that are left then, the file or all devices; null where none is left or it
/// is time to stop. Of fits that are abandoned nothing is told.
std::exception_ptr fit_all(FitDevices& devices, const Samples& samples, const FitOptions& options,
                           const std::vector<Structure>& structures, const FitPlace& place,
                           const FitCalls& calls);

} // namespace brdfit

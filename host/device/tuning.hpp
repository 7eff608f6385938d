#pragma once

#include "host/device/device.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace brdfit {

/// Whether kernels of this form run on the device: powers of 2, a block of whole vectors and
/// groups, a group within the device's limits.
bool is_possible(const Form& form, const Device& device);

nlohmann::ordered_json to_json(const Form& form);

/// The file that keeps what `brdfit tune` found: what BRDFIT_TUNING says, otherwise
/// brdfit/tuning.json in $XDG_CONFIG_HOME or ~/.config. Empty (also BRDFIT_TUNING): none.
std::string tuning_path();

/// A form kept for a device, and how it was found, for people.
struct TunedForm {
    Form form;
    std::string reason;
};

/// The form found for this device, none where driver or kernels have changed since. A file that is
/// none of ours is ignored with a warning.
std::optional<TunedForm> tuned_form(const Device& device);

/// Keeps a form for this device, its driver and the kernels, in place of an older one. Throws
/// InputError where the file cannot be written.
void store_tuned_form(const Device& device, const Form& form,
                      const std::string& reason = "brdfit tune found it");

} // namespace brdfit

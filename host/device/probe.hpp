#pragma once

#include "host/device/device.hpp"

namespace brdfit {

/// Gives an opened device the shipped form that suits it, of vectors or of scalars, and the reason.
/// PoCL makes good code of vectors, GPUs run scalars. Other CPUs are asked by running exp in both
/// forms for some milliseconds. All but PoCL, which the tests run on, are asked for answers that
/// are known: a form in which they are wrong gives way to the other with a warning; where that
/// is wrong too, or there is none, `wrong` says so. Right answers are kept where `brdfit tune`
/// keeps its own (see tuning.hpp), so that a driver is asked once. One that fails gets scalars.
void choose_shipped_form(Device& device);

/// What the device computes wrongly in its form, for people: functions at known values, and sums
/// over groups. Empty where nothing is. Throws DeviceError and cl::Error where it cannot run them.
std::string wrong_answers(const Device& device);

/// Calls of exp a second in the device's form, the best of several runs: how fast it is, about, in
/// some milliseconds. Throws DeviceError and cl::Error where it cannot run them.
double exp_per_second(const Device& device);

} // namespace brdfit

#pragma once

#include "host/device/device.hpp"

namespace brdfit {

/// Gives an opened device the shipped form that suits it, of vectors or of scalars, and the reason.
/// GPUs run scalars and PoCL makes good code of vectors: nothing is measured there. Other CPUs are
/// asked once by running exp in both forms for some milliseconds; a clear answer counts, and is
/// kept where `brdfit tune` keeps its own (see tuning.hpp). A driver that fails gets scalars.
void choose_shipped_form(Device& device);

} // namespace brdfit

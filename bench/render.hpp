#pragma once

#include "bench/work.hpp"
#include "host/device/device.hpp"

namespace brdfit::bench {

inline constexpr const char* render_work = "render";

/// A sphere of rough metal (ggx) of 512 x 512 pixels under the soft box, 64 samples a pixel: a row
/// in samples a second that meet the sphere, each lit by two directions.
Result measure_render(const Device& device, int threads);

} // namespace brdfit::bench

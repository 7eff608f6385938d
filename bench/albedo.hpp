#pragma once

#include "bench/work.hpp"
#include "host/device/device.hpp"
#include "host/model/catalogue.hpp"

#include <cstddef>

namespace brdfit::bench {

inline constexpr const char* table_work = "table";
inline constexpr std::size_t table_size = 64;

/// A lobe's albedo over table_size cosines and as many roughnesses, to 1e-4, on all of the device,
/// kernels compiled before: a row in entries a second. Throws InputError where an entry does not
/// reach the tolerance.
Result measure_table(const Device& device, const Model& model, std::size_t size = table_size);

} // namespace brdfit::bench

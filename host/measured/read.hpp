#pragma once

#include "host/files/file.hpp"
#include "host/measured/samples.hpp"

#include <optional>
#include <string>

namespace brdfit {

/// Reads measured reflectance in any known format, recognised by content, never by name.
/// `isotropic` overrides what the data says (scattered formats only).
/// Throws InputError naming file, place and expectation for every broken input, UsageError where
/// `isotropic` contradicts the format.
Samples read_samples(const std::string& path, std::optional<bool> isotropic = std::nullopt);

/// The format of a measurement, by content; nullptr where it is none. NumPy arrays count whatever
/// they hold.
const char* measured_format(const MappedFile& file);

} // namespace brdfit

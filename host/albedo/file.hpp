#pragma once

#include "host/albedo/material.hpp"

#include <string>

namespace brdfit {

/// Writes an albedo as `.csv` (columns theta, phi in radians, one a channel, <channel>_error, and
/// `measured` for measured data) or `.exr` (float planes of the same names, a row a phi, a column a
/// theta). `source` names the material or file in the provenance. Throws UsageError for another
/// ending.
void write_albedo(const Albedo& albedo, const std::string& path, const std::string& source);

/// The text of such a .csv.
std::string albedo_csv(const Albedo& albedo, const std::string& source);

} // namespace brdfit

#pragma once

#include "host/measured/samples.hpp"
#include "host/progress.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// Writes samples in the format of the name's ending: `.binary` (MERL layout; isotropic data of
/// three channels only; scattered samples are averaged into their bins), `.csv` (scattered:
/// theta_i,phi_i,theta_o,phi_o, one column a channel, `weight` where weights differ from 1),
/// `.astm` (ASTM E1392 text, the same columns),
/// `.npz` (arrays wi, wo, values, weights where there are any, channels; see npz_samples) or `.npy`
/// (float32, columns wi_x,wi_y,wi_z,wo_x,wo_y,wo_z, one a channel, weight; isotropic data turned so
/// that wi_y = 0). Invalid samples are -1 in .binary and left out of the others.
/// `provenance` lines head a .csv as `# ` lines. Throws UsageError for another ending, InputError
/// where the data does not fit the format.
void write_samples(const Samples& samples, const std::string& path,
                   const std::vector<std::string>& provenance = {},
                   const ProgressFunction& progress = {});

/// Throws UsageError for an ending that write_samples does not know.
void require_samples_ending(const std::string& path);

/// Throws InputError where samples cannot be written as MERL .binary to `path`.
void require_merl(const Samples& samples, const std::string& path);

} // namespace brdfit

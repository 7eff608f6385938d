#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/evaluate/relative_error.hpp"
#include "host/measured/rgl.hpp"
#include "host/progress.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A BRDF as a function: 1/sr at each pair of directions, [channel][pair], 0 below the horizon.
using BrdfFunction = std::function<std::vector<float>(const Directions&)>;

/// The nodes of an RGL file's table.
struct RglSize {
    std::size_t phi_i = 1;   ///< 1: isotropic, otherwise at least 3
    std::size_t theta_i = 0; ///< at least 2
    std::size_t side = 0;    ///< of the square over half vectors, at least 2
};

/// What tabulating made of a BRDF.
struct Tabulated {
    RglTables tables;
    RglSize size;
    RelativeError error; ///< at random pairs
};

/// What a table grows to.
struct RglLimits {
    RelativeError enough{0.0025, 0.025};
    std::size_t most_bytes = std::size_t{160} << 20;
};

/// The channels of an RGL file: R, G and B, or wavelengths.
struct RglChannels {
    std::vector<std::string> names;
    std::vector<float> wavelengths;  ///< nm, ascending; empty: R, G, B
    std::vector<std::size_t> source; ///< of each, a channel of the BRDF
};

/// Which channels of a BRDF are which of an RGL file. Channels named by wavelengths stay that;
/// three others are R, G and B, one is all three. `spectral`: R, G and B become a spectrum through
/// 620, 545 and 465 nm, one channel a flat one. Throws InputError, naming `source`, for others.
RglChannels rgl_channels(const std::vector<std::string>& channels, bool spectral,
                         const std::string& source);

/// Tabulates a BRDF as an RGL file: ndf = 1, sigma = 1/4 and vndf = 1, so that the table itself
/// holds f cos(theta_o) over (u_h, v_h), zero below the horizon. `luminance` is what makes an RGL
/// sampler's weights even. Isotropic BRDFs have one phi_i; others cover the circle.
///
/// Without `size` the table grows until the relative error at 20,000 random pairs up to 80 degrees
/// (half of them with the half vector near the normal) is small enough, or growing no longer helps,
/// or the file would be too large.
Tabulated tabulate(const Device& device, const BrdfFunction& brdf, const RglChannels& channels,
                   bool isotropic, std::optional<RglSize> size, const RglLimits& limits = {},
                   const ProgressFunction& progress = {});

} // namespace brdfit

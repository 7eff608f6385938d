#pragma once

#include "host/directions.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace brdfit {

/// Measured (or synthesised) reflectance: K samples of C channels.
struct Samples {
    std::string source; ///< path it was read from
    std::string format; ///< name of the format, for people
    std::string sha256; ///< of the file's bytes; empty when synthesised
    std::vector<std::string> channels;
    std::shared_ptr<const Directions> directions; ///< K pairs; shared between files on one grid
    std::vector<float> values;                    ///< BRDF in 1/sr, [channel][sample]
    std::vector<float> weights;      ///< w_k >= 0, solid-angle measure of the sample; empty: all 1
    std::vector<std::uint8_t> valid; ///< [sample] 0: dropped by every consumer
    /// Nodes of the file's table that are no samples: not measured, or below the horizon.
    std::size_t left_out = 0;
    bool isotropic = true;

    std::size_t count() const { return directions ? directions->count() : 0; }
    const float* channel(std::size_t c) const { return values.data() + c * count(); }
    float* channel(std::size_t c) { return values.data() + c * count(); }
    std::size_t valid_count() const;
};

} // namespace brdfit

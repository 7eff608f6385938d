#pragma once

#include "host/device/device.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace brdfit::bench {

/// The time of a whole albedo table, from the start of the kernels to the last entry.
struct AlbedoResult {
    std::string name; ///< what was computed
    std::string model;
    double seconds = 0; ///< the median of repeated runs, kernels compiled before
    double entries_per_second = 0;
};
nlohmann::ordered_json to_json(const AlbedoResult& result);

/// Times a table of 64 x 64 cosines and roughnesses at a tolerance of 1e-4 of each model of the
/// catalogue, on all of the device; `size` other than 64 for tests.
std::vector<AlbedoResult> measure_albedo_tables(const Device& device, std::size_t size = 64);

} // namespace brdfit::bench

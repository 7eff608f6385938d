#pragma once

#include "host/directions.hpp"

#include <cstdint>
#include <string>
#include <vector>

// RGL files, written and evaluated by the format's definition alone.

namespace brdfit::test {

/// A field of a tensor file.
struct TensorField {
    std::string name;
    int type; ///< 1 uint8, 10 float32
    std::vector<std::uint64_t> shape;
    std::vector<float> values;

    std::size_t count() const;
};

/// The bytes of a tensor file with these fields.
std::string tensor_bytes(const std::vector<TensorField>& fields);

/// A small RGL file's fields, with any values: `phis` slices of azimuth over `turn` from -pi on
/// (one: isotropic), four of theta_i, and 3 channels, or more with wavelengths.
std::vector<TensorField> rgl_fields(std::size_t phis = 1, double turn = 2 * pi,
                                    std::size_t channels = 3);
/// The one of that name.
TensorField& field_of(std::vector<TensorField>& fields, const std::string& name);
/// The fields of a file that tensor_bytes wrote, or any other.
std::vector<TensorField> read_fields(const std::string& bytes);

/// f(wi, wo) of an RGL file in 1/sr, a value a channel, in float64: the share of the density below
/// the half vector is integrated anew for each.
std::vector<double> rgl_reference(const std::vector<TensorField>& fields, Vector wi, Vector wo);

} // namespace brdfit::test

#pragma once

#include "host/error.hpp"
#include "host/evaluate/brdf.hpp"
#include "host/measured/kind.hpp"
#include "host/measured/read.hpp"
#include "host/model/material.hpp"

#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>

namespace brdfit::cli {

/// What read(path) returns. Where it throws InputError and the file is of another kind than
/// expected, the InputError says of which.
template <typename Read>
auto reading(const std::string& path, FileKind expected, Read read) {
    try {
        return read(path);
    } catch (const InputError&) {
        std::string found;
        try {
            const Recognised known = recognised(MappedFile(path));
            if (known.kind != expected)
                found = known.text;
        } catch (const InputError&) { // cannot be read at all, as the first one says
        }
        if (found.empty())
            throw;
        throw InputError(fmt::format("{} is {}; expected {}", path, found, name_of(expected)));
    }
}

inline Material read_material_file(const std::string& path) {
    return reading(path, FileKind::Material, read_material);
}
inline Samples read_measurement(const std::string& path, std::optional<bool> isotropic) {
    return reading(path, FileKind::Measurement,
                   [&](const std::string& file) { return read_samples(file, isotropic); });
}

/// Which of the two a file is that may be a material or a measurement. Throws InputError for a file
/// of another kind; what cannot be told is for the readers to refuse.
inline bool is_measurement(const std::string& path) {
    const MappedFile file(path);
    const Recognised known = recognised(file);
    if (known.kind != FileKind::Measurement && known.kind != FileKind::Material &&
        !known.text.empty())
        throw InputError(
            fmt::format("{} is {}; expected a material file or a measurement", path, known.text));
    const std::size_t first = file.bytes().find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    const bool json = known.text.empty() && first != std::string_view::npos &&
                      file.bytes()[first] == '{'; // a broken material, most likely
    return known.kind != FileKind::Material && !json;
}

/// Reads either. `isotropic` is of scattered measurements only: UsageError with a material.
inline Brdf read_brdf(const std::string& path, std::optional<bool> isotropic = std::nullopt) {
    if (is_measurement(path))
        return Brdf(std::make_unique<MeasuredBrdf>(path, isotropic));
    if (isotropic)
        throw UsageError(fmt::format(
            "--isotropic and --anisotropic: {} is a material; expected them with measured files",
            path));
    return Brdf(read_material(path));
}

} // namespace brdfit::cli

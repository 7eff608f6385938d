#pragma once

#include "host/files/file.hpp"

#include <string>

namespace brdfit {

/// What files brdfit meets, told apart by content.
enum class FileKind {
    Unknown,
    Measurement,
    Material,
    Distribution,
    TableSpec,
    Directions,
    Table,  ///< of a distribution, OpenEXR
    Picture ///< any other image
};

struct Recognised {
    FileKind kind = FileKind::Unknown;
    std::string text; ///< "a measurement (MERL .binary)"; empty where unknown
};

Recognised recognised(const MappedFile& file);
/// As what a kind is asked for: "a material file".
std::string name_of(FileKind kind);

} // namespace brdfit

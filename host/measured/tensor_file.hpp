#pragma once

#include "host/files/file.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// The container of the RGL database's .bsdf files (Dupuy and Jakob 2018): named arrays, little
/// endian. After "tensor_file\0", the version 1 0 and the number of fields as uint32, each field's
/// head is the length of its name (uint16), the name, its dimensions (uint16), its type (uint8),
/// where its data begins in the file (uint64) and its shape (uint64 each), slowest first.
namespace brdfit::tensor_file {

enum class Type : std::uint8_t { U8 = 1, I8, U16, I16, U32, I32, U64, I64, F16, F32, F64 };

/// An array. Lives no longer than the mapped file.
struct Field {
    std::string name;
    Type type = Type::U8;
    std::vector<std::size_t> shape;
    std::size_t offset = 0; ///< of the data in the file
    std::string_view data;  ///< not aligned

    std::size_t count() const; ///< product of the shape
};

bool recognise(std::string_view bytes);

/// The fields in the file's order; their data lies within the file. Throws InputError naming the
/// field and the byte.
std::vector<Field> read(const MappedFile& file);

/// Writes fields, their data aligned to 8 bytes; offsets are not looked at.
void write(const std::string& path, const std::vector<Field>& fields);

} // namespace brdfit::tensor_file

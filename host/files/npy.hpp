#pragma once

#include "host/files/file.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// NumPy's array file, as far as tables of floating point numbers need it.
namespace brdfit::npy {

/// A mapped array of rows and columns, row after row. Lives no longer than the file.
struct Array {
    std::size_t rows = 0, columns = 0;
    bool float64 = false;
    const char* data = nullptr; ///< not aligned

    double at(std::size_t row, std::size_t column) const;
};

bool recognise(std::string_view bytes);
/// Throws InputError for anything but a whole little-endian float32 or float64 table in C order.
Array read(const MappedFile& file);
/// The same of bytes that `name` stands for in messages. An array of one dimension is a column
/// where `column` allows it.
Array read(std::string_view bytes, const std::string& name, bool column = false);
/// An array of texts, of one dimension: UTF-32 (`<U`) or bytes (`|S`).
std::vector<std::string> read_texts(std::string_view bytes, const std::string& name);
/// The bytes ahead of, and of, an array of texts in UTF-8, as read_texts reads it.
std::string texts(const std::vector<std::string>& texts);
/// The bytes ahead of an array in C order, the last dimension fastest. `type`: '<f4' and the like.
std::string header(const std::vector<std::size_t>& shape, const std::string& type);
/// The bytes ahead of a float32 table.
std::string header(std::size_t rows, std::size_t columns);

} // namespace brdfit::npy

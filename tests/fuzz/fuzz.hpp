#pragma once

#include "host/error.hpp"
#include "host/image/image.hpp"
#include "host/measured/samples.hpp"
#include "host/microfacet/table.hpp"

#include <cstddef>
#include <cstdint>
#include <string>

// What fuzzers share: a reader either reads a file, and then what it returns is whole, or throws an
// InputError that begins with the file's name. Anything else ends the process: libFuzzer's finding.

namespace brdfit::fuzz {

/// Path of a file in memory with these bytes, in place of the input before.
const std::string& input_file(const std::uint8_t* data, std::size_t size);

/// Whether this input is the one in `count` that is given what takes long, once. Of the bytes, so
/// that another run does the same.
bool one_in(std::uint32_t count, const std::uint8_t* data, std::size_t size);

/// A new folder, for files that inputs name; what makes it removes it ($TMPDIR is where it stands).
const std::string& folder();

/// Ends the process where `holds` is not true.
void require(bool holds, const char* what, const std::string& which = "");

/// Calls read(). Whether it returned; where it threw an InputError, its message must begin with
/// `path`.
template <typename Read>
bool reads(const std::string& path, const Read& read) {
    try {
        read();
    } catch (const InputError& error) {
        const std::string message = error.what();
        require(message.rfind(path + ": ", 0) == 0, "a message without the file", message);
        return false;
    }
    return true;
}

/// Ends the process unless sizes agree and what is valid is finite.
void check(const Samples& samples);
void check(const Directions& directions);
void check(const Image& image);
/// The same, and that what the kernels read of the table can be made.
void check(const MicrofacetTable& table);

/// A small table that write_table writes: over all azimuths, with an image, tabulated values and
/// facets, or isotropic.
MicrofacetTable example_table(bool isotropic);
/// A small image with plane `channel` of values above 0.
Image example_image(const std::string& channel);
/// Writes it as PNG.
void write_png(const Image& image, const std::string& path);

} // namespace brdfit::fuzz

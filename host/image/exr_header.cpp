#include "host/image/exr_header.hpp"

#include "host/error.hpp"
#include "host/files/text.hpp"
#include "host/image/limits.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <string>

// The layout of headers: openexr.com, "OpenEXR File Layout". Numbers are little-endian.

namespace brdfit {

namespace {

constexpr std::size_t most_parts = 1024, most_attributes = 4096, most_header_bytes = 1 << 26,
                      longest_name = 255;
constexpr std::uint32_t multi_part_flag = 0x1000, deep_flag = 0x800, tiled_flag = 0x200;
// Lines in a chunk, by compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
constexpr std::array<std::size_t, 10> chunk_lines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

// Types of one size: OpenEXR reads that many bytes, whatever the attribute's size is.
const std::map<std::string_view, std::size_t> sizes{{"box2f", 16},
                                                    {"box2i", 16},
                                                    {"chromaticities", 32},
                                                    {"compression", 1},
                                                    {"deepImageState", 1},
                                                    {"double", 8},
                                                    {"envmap", 1},
                                                    {"float", 4},
                                                    {"int", 4},
                                                    {"keycode", 28},
                                                    {"lineOrder", 1},
                                                    {"m33d", 72},
                                                    {"m33f", 36},
                                                    {"m44d", 128},
                                                    {"m44f", 64},
                                                    {"rational", 8},
                                                    {"tiledesc", 9},
                                                    {"timecode", 8},
                                                    {"v2d", 16},
                                                    {"v2f", 8},
                                                    {"v2i", 8},
                                                    {"v3d", 24},
                                                    {"v3f", 12},
                                                    {"v3i", 12}};

struct Window {
    std::size_t width = 0, height = 0;
};

// What a part's header says of its size.
struct Part {
    std::optional<std::size_t> channels, compression, chunks;
    std::optional<Window> window, tiles;
    std::string type;
};

// Reads the bytes from `begin` to `end`; errors say in which part and attribute.
class Walk {
  public:
    Walk(std::string_view bytes, std::size_t begin, std::size_t end, std::string place)
        : place_(std::move(place)), bytes_(bytes), at_(begin), end_(end) {}

    // The next `size` bytes for themselves.
    Walk part(std::size_t size, std::string_view name) {
        const std::string place = fmt::format("{}attribute {}: ", place_, text::quoted(name));
        if (size > end_ - at_)
            throw InputError(fmt::format("{}byte {}: a size of {} bytes; expected at most the {} "
                                         "that are left of {}",
                                         place, at_, size, end_ - at_,
                                         end_ == bytes_.size() ? "the file" : "all headers"));
        at_ += size;
        return {bytes_, at_ - size, at_, place};
    }
    std::string_view take(std::size_t count) {
        if (count > end_ - at_)
            fail("ends early");
        at_ += count;
        return bytes_.substr(at_ - count, count);
    }
    std::size_t left() const { return end_ - at_; }
    std::string_view rest() { return take(left()); }
    std::int32_t number() {
        const std::string_view four = take(4);
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value |= std::uint32_t{static_cast<unsigned char>(four[i])} << (8 * i);
        return static_cast<std::int32_t>(value);
    }
    // A text up to its 0.
    std::string_view name() {
        const std::string_view near = bytes_.substr(at_, std::min(end_ - at_, longest_name + 1));
        const std::size_t length = near.find('\0');
        if (length == std::string_view::npos)
            fail(fmt::format("a name does not end within {} bytes", near.size()));
        return take(length + 1).substr(0, length);
    }
    bool at_zero() const { return at_ < end_ && bytes_[at_] == '\0'; }
    void enter(const std::string& place) { place_ = place; }
    [[noreturn]] void fail(const std::string& problem) const {
        throw InputError(fmt::format("{}byte {}: {}", place_, at_, problem));
    }

  private:
    std::string place_;
    std::string_view bytes_;
    std::size_t at_, end_;
};

std::size_t count_channels(Walk& walk) {
    constexpr std::size_t after_name = 16; // type, linearity, sampling
    std::size_t count = 0;
    for (; !walk.name().empty(); ++count)
        walk.take(after_name);
    if (walk.left() != 0)
        walk.fail(fmt::format("{} bytes after the last channel; expected none", walk.left()));
    return count;
}

Window read_window(Walk& walk) {
    const std::int64_t left = walk.number(), top = walk.number(), right = walk.number(),
                       bottom = walk.number();
    if (right < left || bottom < top)
        walk.fail(fmt::format("a window from {}, {} to {}, {}; expected at least one pixel", left,
                              top, right, bottom));
    return {static_cast<std::size_t>(right - left + 1), static_cast<std::size_t>(bottom - top + 1)};
}

Window read_tiles(Walk& walk) {
    const std::int64_t width = walk.number(), height = walk.number();
    if (width < 1 || height < 1)
        walk.fail(fmt::format("tiles of {} x {} pixels; expected at least one", width, height));
    return {static_cast<std::size_t>(width), static_cast<std::size_t>(height)};
}

// Checks an attribute, and notes what says how large the part is.
void note(Part& part, std::string_view name, std::string_view type, Walk walk) {
    if (const auto known = sizes.find(type); known != sizes.end() && walk.left() != known->second)
        walk.fail(fmt::format("a size of {} bytes; expected {} for type {}", walk.left(),
                              known->second, type));
    if (type == "chlist") { // whatever its name is, OpenEXR reads to the last channel
        const std::size_t channels = count_channels(walk);
        if (name == "channels")
            part.channels = channels;
    } else if (name == "dataWindow" && type == "box2i") {
        part.window = read_window(walk);
    } else if (name == "tiles" && type == "tiledesc") {
        part.tiles = read_tiles(walk);
    } else if (name == "compression" && type == "compression") {
        part.compression = static_cast<unsigned char>(walk.take(1)[0]);
    } else if (name == "chunkCount" && type == "int") {
        const std::int32_t chunks = walk.number();
        if (chunks < 0)
            walk.fail(fmt::format("{} chunks; expected none or more", chunks));
        part.chunks = static_cast<std::size_t>(chunks);
    } else if (name == "type") {
        part.type = walk.rest();
    }
}

std::size_t pieces(std::size_t whole, std::size_t piece) {
    return (whole + piece - 1) / piece;
}

// Whether the file can hold what a header says, and a reader one chunk of it.
void check_size(const Part& part, bool tiled, std::size_t bytes) {
    const char* const missing = !part.channels           ? "channels"
                                : !part.window           ? "dataWindow"
                                : !part.compression      ? "compression"
                                : (tiled && !part.tiles) ? "tiles"
                                                         : nullptr;
    if (missing != nullptr)
        throw InputError(fmt::format("has no attribute {}", missing));
    if (*part.compression >= chunk_lines.size())
        throw InputError(fmt::format("compression {}; expected one of 0 to {}", *part.compression,
                                     chunk_lines.size() - 1));
    const Window image = *part.window;
    check_image_size(image.width, image.height, *part.channels, bytes);
    const Window chunk = tiled ? *part.tiles : Window{image.width, chunk_lines[*part.compression]};
    if (chunk.width > most_image_values || chunk.height > most_image_values / chunk.width ||
        *part.channels > most_image_values / (chunk.width * chunk.height))
        throw InputError(fmt::format("chunks of {} x {} pixels of {} channels; expected at most {} "
                                     "values",
                                     chunk.width, chunk.height, *part.channels, most_image_values));
    const std::size_t chunks =
        std::max(pieces(image.width, chunk.width) * pieces(image.height, chunk.height),
                 part.chunks.value_or(0));
    if (chunks > bytes / 8) // each has a place in the file of 8 bytes
        throw InputError(fmt::format("{} bytes cannot hold {} chunks", bytes, chunks));
}

Part read_part(Walk& walk) {
    Part part;
    std::size_t attributes = 0;
    for (std::string_view name = walk.name(); !name.empty(); name = walk.name()) {
        if (++attributes > most_attributes)
            walk.fail(fmt::format("more than {} attributes; expected fewer", most_attributes));
        const std::string_view type = walk.name();
        const std::int32_t size = walk.number();
        if (size < 0)
            walk.fail(fmt::format("attribute {}: a size of {}; expected 0 or more",
                                  text::quoted(name), size));
        note(part, name, type, walk.part(static_cast<std::size_t>(size), name));
    }
    return part;
}

} // namespace

void check_exr_headers(std::string_view bytes) {
    Walk walk(bytes, 0, std::min(bytes.size(), most_header_bytes), "");
    if (walk.take(4) != "\x76\x2f\x31\x01")
        throw InputError("does not begin like one");
    const auto version = static_cast<std::uint32_t>(walk.number());
    const bool many = (version & multi_part_flag) != 0;
    const bool by_type = many || (version & deep_flag) != 0;
    for (std::size_t k = 0; many ? k == 0 || !walk.at_zero() : k == 0; ++k) {
        if (k == most_parts)
            throw InputError(fmt::format("more than {} parts; expected fewer", most_parts));
        const std::string place = many ? fmt::format("part {}: ", k) : "";
        walk.enter(place);
        const Part part = read_part(walk);
        const bool tiled =
            by_type ? part.type.find("tile") != std::string::npos : (version & tiled_flag) != 0;
        try {
            check_size(part, tiled, bytes.size());
        } catch (const InputError& error) {
            throw InputError(place + error.what());
        }
    }
}

} // namespace brdfit

#include "host/files/zip.hpp"

#include "host/error.hpp"
#include "host/files/text.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <zlib.h>

namespace brdfit::zip {

namespace {

constexpr std::string_view local_magic = "PK\x03\x04", central_magic = "PK\x01\x02",
                           end_magic = "PK\x05\x06", end64_magic = "PK\x06\x06",
                           locator_magic = "PK\x06\x07";
constexpr std::size_t local_bytes = 30, central_bytes = 46, end_bytes = 22, locator_bytes = 20,
                      end64_bytes = 56;
constexpr std::uint16_t zip64_extra = 1, version = 45;
constexpr std::uint64_t in_zip64 = 0xffffffff; // of a field: it is in the extra one
// Deflate packs at most 258 bytes into two bits.
constexpr std::size_t most_ratio = 1032, slack = 1024;
constexpr std::size_t most_members = 65536;

/// A little-endian number of `bytes` bytes.
std::uint64_t number(std::string_view from, std::size_t at, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = bytes; i-- > 0;)
        value = value << 8 | static_cast<unsigned char>(from[at + i]);
    return value;
}

void put(std::string& to, std::uint64_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i)
        to += static_cast<char>(value >> 8 * i & 0xff);
}

[[noreturn]] void fail(const MappedFile& file, const std::string& message) {
    throw InputError(fmt::format("{}: zip archive: {}", file.path(), message));
}

/// `size` bytes of the file, which `what` names.
std::string_view part(const MappedFile& file, std::uint64_t at, std::uint64_t size,
                      const std::string& what) {
    const std::string_view bytes = file.bytes();
    if (at > bytes.size() || size > bytes.size() - at)
        fail(file,
             fmt::format("{} at byte {} goes beyond its end, byte {}", what, at, bytes.size()));
    return bytes.substr(at, size);
}

/// What the end of an archive says of its directory.
struct End {
    std::uint64_t members, size, offset;
};

End find_end(const MappedFile& file) {
    const std::string_view bytes = file.bytes();
    const std::size_t at = bytes.rfind(end_magic); // a comment may follow
    if (at == bytes.npos || bytes.size() - at < end_bytes)
        fail(file, "no directory at its end; it is cut off, or still being written");
    End end{number(bytes, at + 10, 2), number(bytes, at + 12, 4), number(bytes, at + 16, 4)};
    if (number(bytes, at + 4, 2) != 0 && number(bytes, at + 4, 2) != 0xffff)
        fail(file, "it is one of several parts; expected a whole one");
    const bool zip64 = end.members == 0xffff || end.size == in_zip64 || end.offset == in_zip64;
    if (!zip64 || at < locator_bytes ||
        bytes.substr(at - locator_bytes, locator_magic.size()) != locator_magic)
        return end;
    const std::string_view record =
        part(file, number(bytes, at - locator_bytes + 8, 8), end64_bytes, "the zip64 record");
    if (record.substr(0, end64_magic.size()) != end64_magic)
        fail(file, "the zip64 record does not begin with its mark");
    return {number(record, 32, 8), number(record, 40, 8), number(record, 48, 8)};
}

/// Replaces those numbers of a directory's entry that are in its zip64 field.
void read_zip64(const MappedFile& file, std::string_view extra, const std::string& name,
                std::initializer_list<std::uint64_t*> values) {
    while (extra.size() >= 4) {
        const std::uint64_t id = number(extra, 0, 2), size = number(extra, 2, 2);
        extra.remove_prefix(4);
        if (size > extra.size())
            break;
        std::string_view field = extra.substr(0, size);
        extra.remove_prefix(size);
        if (id != zip64_extra)
            continue;
        for (std::uint64_t* const value : values)
            if (*value == in_zip64 && field.size() >= 8) {
                *value = number(field, 0, 8);
                field.remove_prefix(8);
            }
        return;
    }
    for (const std::uint64_t* const value : values)
        if (*value == in_zip64)
            fail(file, fmt::format("{}: its zip64 field is missing", text::quoted(name)));
}

/// The member that a directory's entry tells of, whose name and extra field follow.
Member member_of(const MappedFile& file, std::string_view entry, std::string_view name,
                 std::string_view extra) {
    Member member;
    member.name = name;
    const auto refuse = [&](const std::string& message) {
        fail(file, fmt::format("{}: {}", text::quoted(name), message));
    };
    const std::uint64_t method = number(entry, 10, 2);
    if ((number(entry, 8, 2) & 1) != 0)
        refuse("it is encrypted");
    if (method != 0 && method != 8)
        refuse(
            fmt::format("it is packed by method {}; expected 0 (stored) or 8 (deflated)", method));
    member.deflated = method == 8;
    member.crc = static_cast<std::uint32_t>(number(entry, 16, 4));
    std::uint64_t packed = number(entry, 20, 4), size = number(entry, 24, 4),
                  offset = number(entry, 42, 4);
    read_zip64(file, extra, member.name, {&size, &packed, &offset});
    const std::string_view local = part(file, offset, local_bytes, text::quoted(name));
    if (local.substr(0, local_magic.size()) != local_magic)
        refuse(fmt::format("no member begins at byte {}", offset));
    member.packed = part(file, offset + local_bytes + number(local, 26, 2) + number(local, 28, 2),
                         packed, text::quoted(name));
    if (member.deflated ? size > slack && (size - slack) / most_ratio > packed : size != packed)
        refuse(fmt::format("{} bytes cannot come of {} packed ones", size, packed));
    member.size = size;
    return member;
}

void require_crc(const MappedFile& file, const Member& member, std::string_view bytes) {
    if (crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != member.crc)
        fail(file, fmt::format("{}: its checksum does not agree: it is damaged",
                               text::quoted(member.name)));
}

} // namespace

bool recognise(std::string_view bytes) {
    return bytes.substr(0, local_magic.size()) == local_magic;
}

std::vector<Member> directory(const MappedFile& file) {
    const End end = find_end(file);
    std::string_view rest = part(file, end.offset, end.size, "the directory");
    if (end.members > most_members || end.members > rest.size() / central_bytes)
        fail(file, fmt::format("{} members in a directory of {} bytes", end.members, rest.size()));
    std::vector<Member> members;
    for (std::uint64_t k = 0; k < end.members; ++k) {
        if (rest.size() < central_bytes || rest.substr(0, 4) != central_magic)
            fail(file, fmt::format("its directory ends after {} of {} members", k, end.members));
        const std::string_view entry = rest.substr(0, central_bytes);
        const std::size_t name = number(entry, 28, 2), extra = number(entry, 30, 2),
                          comment = number(entry, 32, 2);
        rest.remove_prefix(central_bytes);
        if (name + extra + comment > rest.size())
            fail(file, fmt::format("its directory ends after {} of {} members", k, end.members));
        members.push_back(member_of(file, entry, rest.substr(0, name), rest.substr(name, extra)));
        rest.remove_prefix(name + extra + comment);
    }
    return members;
}

std::string_view unpack(const MappedFile& file, const Member& member, std::string& buffer) {
    if (!member.deflated) {
        require_crc(file, member, member.packed);
        return member.packed;
    }
    constexpr std::size_t most_at_once = std::size_t{1} << 30; // zlib counts in 32 bits
    const auto broken = [&] {
        fail(file, fmt::format("{}: it cannot be unpacked to {} bytes: it is damaged",
                               text::quoted(member.name), member.size));
    };
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK)
        throw InputError(fmt::format("{}: no memory to unpack it", file.path()));
    const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);
    buffer.clear();
    std::size_t taken = 0;
    int status = Z_OK;
    while (status != Z_STREAM_END) {
        // The buffer grows with what comes, not with what the directory says.
        const std::size_t before = buffer.size();
        buffer.resize(std::min(
            {member.size + 1, before + most_at_once, std::max(2 * before, std::size_t{1} << 16)}));
        stream.next_out = reinterpret_cast<Bytef*>(buffer.data() + before);
        stream.avail_out = static_cast<uInt>(buffer.size() - before);
        const std::size_t piece = std::min(member.packed.size() - taken, most_at_once);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(member.packed.data() + taken));
        stream.avail_in = static_cast<uInt>(piece);
        status = inflate(&stream, Z_NO_FLUSH);
        taken += piece - stream.avail_in;
        const std::size_t made = buffer.size() - before - stream.avail_out;
        buffer.resize(before + made);
        if ((status != Z_OK && status != Z_STREAM_END) || (made == 0 && status == Z_OK) ||
            buffer.size() > member.size)
            broken();
    }
    if (buffer.size() != member.size)
        broken();
    require_crc(file, member, buffer);
    return buffer;
}

void Writer::add(const std::string& name, std::string_view head, std::string_view data) {
    const std::uint64_t size = head.size() + data.size();
    uLong crc = crc32_z(0, nullptr, 0);
    for (const std::string_view part : {head, data})
        if (!part.empty()) // zlib takes null for the start of a sum
            crc = crc32_z(crc, reinterpret_cast<const Bytef*>(part.data()), part.size());
    // What the two headers share. Sizes and offset always stand in the zip64 field: one form.
    std::string shared;
    put(shared, version, 2);
    put(shared, 0, 2);    // flags
    put(shared, 0, 2);    // stored
    put(shared, 0, 2);    // midnight
    put(shared, 0x21, 2); // of 1980-01-01: the same bytes for the same data
    put(shared, crc, 4);
    put(shared, in_zip64, 4);
    put(shared, in_zip64, 4);
    put(shared, name.size(), 2);

    std::string local(local_magic);
    local += shared;
    put(local, 20, 2);
    local += name;
    put(local, zip64_extra, 2);
    put(local, 16, 2);
    put(local, size, 8);
    put(local, size, 8);
    file_.write(local);
    file_.write(head);
    file_.write(data);

    directory_ += central_magic;
    put(directory_, version, 2);
    directory_ += shared;
    put(directory_, 28, 2);
    put(directory_, 0, 2); // comment
    put(directory_, 0, 2); // disk
    put(directory_, 0, 2);
    put(directory_, 0, 4);
    put(directory_, in_zip64, 4);
    directory_ += name;
    put(directory_, zip64_extra, 2);
    put(directory_, 24, 2);
    put(directory_, size, 8);
    put(directory_, size, 8);
    put(directory_, at_, 8);
    at_ += local.size() + size;
    ++members_;
}

void Writer::commit() {
    std::string end(end64_magic);
    put(end, end64_bytes - 12, 8);
    put(end, version, 2);
    put(end, version, 2);
    put(end, 0, 8); // disks
    put(end, members_, 8);
    put(end, members_, 8);
    put(end, directory_.size(), 8);
    put(end, at_, 8);
    end += locator_magic;
    put(end, 0, 4);
    put(end, at_ + directory_.size(), 8);
    put(end, 1, 4);
    end += end_magic;
    put(end, 0, 4);
    put(end, 0xffff, 2);
    put(end, 0xffff, 2);
    put(end, in_zip64, 4);
    put(end, in_zip64, 4);
    put(end, 0, 2);
    file_.write(directory_);
    file_.write(end);
    file_.commit();
}

} // namespace brdfit::zip

#pragma once

#include "host/files/file.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Zip archives (PKWARE's APPNOTE 6.3), with zip64, as far as NumPy's .npz needs them: members that
/// are stored or deflated.
namespace brdfit::zip {

bool recognise(std::string_view bytes);

struct Member {
    std::string name;
    std::string_view packed; ///< its bytes in the file
    bool deflated = false;
    std::size_t size = 0; ///< unpacked
    std::uint32_t crc = 0;
};

/// The members of an archive, in its directory's order; they live no longer than the file. Throws
/// InputError for a broken archive, sizes that the file cannot hold, and what is encrypted, in
/// parts or packed otherwise.
std::vector<Member> directory(const MappedFile& file);

/// The bytes of a member; those of a stored one are where they are, others go to `buffer`, which
/// grows as they come. Throws InputError where they are damaged.
std::string_view unpack(const MappedFile& file, const Member& member, std::string& buffer);

/// Writes an archive of stored members, each in one piece; the file appears whole or not at all.
class Writer {
  public:
    explicit Writer(const std::string& path) : file_(path) {}
    /// `head` and `data`: the member's bytes, one after the other.
    void add(const std::string& name, std::string_view head, std::string_view data);
    void commit();

  private:
    OutputFile file_;
    std::string directory_;
    std::uint64_t at_ = 0, members_ = 0;
};

} // namespace brdfit::zip

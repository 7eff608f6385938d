#include "host/measured/tensor_file.hpp"

#include "host/error.hpp"
#include "host/files/text.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <iterator>

namespace brdfit::tensor_file {

namespace {

constexpr std::string_view magic("tensor_file\0", 12), version("\1\0", 2);
constexpr std::size_t most_fields = 256, most_dimensions = 8, alignment = 8;

/// Bytes of a value of each type; 0 for a number that is no type.
std::size_t size_of(Type type) {
    constexpr std::size_t sizes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
    const auto i = static_cast<std::size_t>(type);
    return i < std::size(sizes) ? sizes[i] : 0;
}

/// Reads the head of the file, number after number.
class Head {
  public:
    explicit Head(const MappedFile& file) : file_(file) {}

    template <typename Number>
    Number number(std::string_view what) {
        Number value;
        std::memcpy(&value, bytes(sizeof value, what).data(), sizeof value);
        return value;
    }
    std::string_view bytes(std::size_t count, std::string_view what) {
        const std::string_view all = file_.bytes();
        if (count > all.size() - at_)
            fail(fmt::format("the file ends within {}", what));
        at_ += count;
        return all.substr(at_ - count, count);
    }
    [[noreturn]] void fail(std::string_view message) const {
        throw InputError(fmt::format("{}: {}byte {}: {}", file_.path(), where, at_, message));
    }
    std::string where; ///< the field, for messages

  private:
    const MappedFile& file_;
    std::size_t at_ = 0;
};

/// The bytes that an array takes. Fails where that is more than `most`.
std::size_t bytes_of(const Head& head, const Field& field, std::size_t most) {
    if (std::find(field.shape.begin(), field.shape.end(), 0U) != field.shape.end())
        return 0;
    std::size_t bytes = size_of(field.type);
    for (const std::size_t length : field.shape) {
        if (length > most / bytes)
            head.fail(fmt::format("shape {}; the file holds {} bytes",
                                  fmt::join(field.shape, " x "), most));
        bytes *= length;
    }
    return bytes;
}

Field read_field(Head& head, std::string_view file) {
    Field field;
    const auto length = head.number<std::uint16_t>("the length of the name");
    field.name = head.bytes(length, "the name");
    head.where = fmt::format("field {}: ", text::quoted(field.name));
    const auto dimensions = head.number<std::uint16_t>("the number of dimensions");
    if (dimensions > most_dimensions)
        head.fail(fmt::format("{} dimensions; expected at most {}", dimensions, most_dimensions));
    const auto type = head.number<std::uint8_t>("the type");
    field.type = static_cast<Type>(type);
    if (size_of(field.type) == 0)
        head.fail(fmt::format("type {}; expected 1 to 11", type));
    const auto offset = head.number<std::uint64_t>("the offset");
    for (std::size_t d = 0; d < dimensions; ++d)
        field.shape.push_back(head.number<std::uint64_t>("the shape"));
    const std::size_t bytes = bytes_of(head, field, file.size());
    if (offset > file.size() || bytes > file.size() - offset)
        head.fail(fmt::format("its {} bytes from byte {} on end after the file's {}", bytes, offset,
                              file.size()));
    field.offset = offset;
    field.data = file.substr(offset, bytes);
    return field;
}

} // namespace

std::size_t Field::count() const {
    return data.size() / size_of(type);
}

bool recognise(std::string_view bytes) {
    return bytes.substr(0, magic.size() - 1) == magic.substr(0, magic.size() - 1);
}

std::vector<Field> read(const MappedFile& file) {
    Head head(file);
    head.where = "header: ";
    if (head.bytes(magic.size(), "the magic bytes") != magic)
        head.fail("no tensor file; expected \"tensor_file\" and a zero byte");
    const std::string_view found = head.bytes(version.size(), "the version");
    if (found != version)
        head.fail(fmt::format("version {}.{}; expected 1.0", static_cast<unsigned char>(found[0]),
                              static_cast<unsigned char>(found[1])));
    const auto count = head.number<std::uint32_t>("the number of fields");
    if (count > most_fields)
        head.fail(fmt::format("{} fields; expected at most {}", count, most_fields));
    std::vector<Field> fields;
    for (std::uint32_t i = 0; i < count; ++i) {
        head.where = fmt::format("field {} of {}: ", i + 1, count);
        fields.push_back(read_field(head, file.bytes()));
        for (std::size_t j = 0; j + 1 < fields.size(); ++j)
            if (fields[j].name == fields.back().name)
                head.fail("a second field of this name");
    }
    return fields;
}

void write(const std::string& path, const std::vector<Field>& fields) {
    std::string head(magic);
    const auto put = [&head](auto value) {
        head.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    head += version;
    put(static_cast<std::uint32_t>(fields.size()));
    std::size_t end = head.size();
    for (const Field& field : fields)
        end += 2 + field.name.size() + 2 + 1 + 8 + 8 * field.shape.size();
    const auto aligned = [](std::size_t n) { return (n + alignment - 1) / alignment * alignment; };
    for (const Field& field : fields) {
        put(static_cast<std::uint16_t>(field.name.size()));
        head += field.name;
        put(static_cast<std::uint16_t>(field.shape.size()));
        put(static_cast<std::uint8_t>(field.type));
        put(static_cast<std::uint64_t>(aligned(end)));
        for (const std::size_t length : field.shape)
            put(static_cast<std::uint64_t>(length));
        end = aligned(end) + field.data.size();
    }
    OutputFile file(path);
    file.write(head);
    std::size_t at = head.size();
    for (const Field& field : fields) {
        file.write(std::string(aligned(at) - at, '\0'));
        file.write(field.data);
        at = aligned(at) + field.data.size();
    }
    file.commit();
}

} // namespace brdfit::tensor_file

#include "tests/fuzz/fuzz.hpp"

#include <zlib.h>

using namespace brdfit;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

// Chunks with a wrong check sum are not looked at: most mutations get right ones.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
    size = LLVMFuzzerMutate(data, size, most);
    std::size_t at = 8; // behind the signature: length, name and data, check sum of both
    while (seed % 8 != 0 && at + 12 <= size) {
        const std::uint8_t* const n = data + at;
        const std::size_t length =
            std::size_t{n[0]} << 24 | std::size_t{n[1]} << 16 | std::size_t{n[2]} << 8 | n[3];
        if (length > size - at - 12)
            break;
        const uLong sum = crc32(0, n + 4, static_cast<uInt>(length + 4));
        at += 8 + length;
        for (int byte = 3; byte >= 0; --byte)
            data[at++] = static_cast<std::uint8_t>(sum >> 8 * byte);
    }
    return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { fuzz::check(read_png(path)); });
    return 0;
}

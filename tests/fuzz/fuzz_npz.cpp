#include "host/files/zip.hpp"
#include "host/measured/formats.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

namespace {

void read(const std::string& path) {
    fuzz::reads(path, [&] { fuzz::check(npz_samples::read(MappedFile(path), std::nullopt)); });
}

} // namespace

// The input as an archive, and an archive of the arrays in it, whose checksums are right.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    read(fuzz::input_file(data, size));

    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    constexpr std::string_view magic = "\x93NUMPY";
    const std::string path = fuzz::folder() + "/arrays.npz";
    zip::Writer writer(path);
    std::size_t at = bytes.find(magic);
    for (const char* name : {"wi.npy", "wo.npy", "values.npy", "weights.npy", "channels.npy"}) {
        if (at == bytes.npos)
            break;
        const std::size_t next = bytes.find(magic, at + 1);
        writer.add(name, bytes.substr(at, next - at), {});
        at = next;
    }
    writer.commit();
    read(path);
    return 0;
}

#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { fuzz::check(read_exr(path)); });
    fuzz::reads(path, [&] {
        for (const Image& image : read_exr_parts(path))
            fuzz::check(image);
    });
    return 0;
}

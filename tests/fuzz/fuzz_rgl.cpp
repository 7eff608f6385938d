#include "host/measured/rgl.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { fuzz::check(rgl::read(MappedFile(path), std::nullopt)); });
    return 0;
}

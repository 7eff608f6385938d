#include "host/measured/kind.hpp"
#include "host/measured/read.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

// All formats, and which one a file is of.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { recognised(MappedFile(path)); });
    fuzz::reads(path, [&] { fuzz::check(read_samples(path)); });
    return 0;
}

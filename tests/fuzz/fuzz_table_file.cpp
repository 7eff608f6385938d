#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

// The OpenEXR files that brdfit generate makes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    std::shared_ptr<const MicrofacetTable> table;
    if (fuzz::reads(path, [&] { table = read_table(path); }))
        fuzz::check(*table);
    return 0;
}

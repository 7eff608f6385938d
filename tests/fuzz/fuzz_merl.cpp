#include "host/measured/merl.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <filesystem>

using namespace brdfit;

// A whole file has 35 MB, too many to change at random: inputs are how it begins, zeros follow.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t whole = 12 + 3 * merl::bins * sizeof(double);
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { merl::read(MappedFile(path)); });
    if (size < 12)
        return 0;
    std::filesystem::resize_file(path, whole);
    fuzz::reads(path, [&] { fuzz::check(merl::read(MappedFile(path))); });
    return 0;
}

#include "host/measured/formats.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

using namespace brdfit;

namespace {

/// One in so many is given as a whole file, which takes as long as thousands of others.
constexpr std::uint32_t between_whole_ones = 64;

} // namespace

// Known by its size, 2 MB: inputs are how a file begins, zeros follow. The table alone depends on
// the bytes; directions and weights are those of every file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t values = utia::channels * utia::directions * utia::directions,
                          whole = values * sizeof(double);
    static const bool checked = [] {
        const std::string& path = fuzz::input_file(nullptr, 0);
        std::filesystem::resize_file(path, whole);
        fuzz::check(utia::read(MappedFile(path), std::nullopt));
        return true;
    }();
    fuzz::require(checked, "a file of zeros");
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { utia::read_table(MappedFile(path)); });
    if (!fuzz::one_in(between_whole_ones, data, size))
        return 0;
    std::filesystem::resize_file(path, whole);
    fuzz::reads(path, [&] {
        const std::vector<float> table = utia::read_table(MappedFile(path));
        fuzz::require(table.size() == values, "values of another number");
        fuzz::require(std::all_of(table.begin(),
                                  table.begin() + static_cast<std::ptrdiff_t>(size / 8 + 1),
                                  [](float x) { return std::isfinite(x); }),
                      "a value that is not finite");
    });
    return 0;
}

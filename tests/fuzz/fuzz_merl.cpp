#include "host/measured/merl.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>
#include <filesystem>

using namespace brdfit;

namespace {

/// One in so many is given as a whole file, which takes as long as thousands of others.
constexpr std::uint32_t between_whole_ones = 4096;

} // namespace

// A whole file has 35 MB, too many to change at random: inputs are how it begins, zeros follow.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t whole = 12 + 3 * merl::bins * sizeof(double);
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] { merl::recognise(MappedFile(path).bytes()); });
    fuzz::reads(path, [&] { merl::read(MappedFile(path)); });
    if (size < 12 || !fuzz::one_in(between_whole_ones, data, size))
        return 0;
    std::filesystem::resize_file(path, whole);
    fuzz::reads(path, [&] {
        const Samples samples = merl::read(MappedFile(path));
        fuzz::require(samples.count() == merl::bins && samples.values.size() == 3 * merl::bins &&
                          samples.valid.size() == merl::bins,
                      "values of another number");
        for (std::size_t k = 0; k < size / sizeof(double) + 1; ++k)
            fuzz::require(std::isfinite(samples.values[k]), "a value that is not finite");
    });
    return 0;
}

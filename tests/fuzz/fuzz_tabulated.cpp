#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] {
        const auto table = read_tabulated(path);
        fuzz::require(table->height == table->thetas.size() && table->width == table->phis.size() &&
                          table->values.size() == table->height * table->width,
                      "a table of another size");
        check_values(*table, path);
    });
    return 0;
}

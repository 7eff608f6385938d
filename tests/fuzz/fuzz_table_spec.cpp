#include "host/table/table.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace brdfit;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] {
        const TableSpec spec = read_table_spec(path);
        fuzz::require(spec.entries() > 0 && spec.entries() <= most_entries, "a number of entries");
        for (const Axis& axis : spec.axes)
            for (const std::size_t i : {std::size_t{0}, axis.size / 2, axis.size - 1})
                fuzz::require(std::isfinite(axis.value(i)), "a node that is not finite");
    });
    return 0;
}

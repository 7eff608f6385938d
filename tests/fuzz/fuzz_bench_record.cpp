#include "bench/compare.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

// What brdfit bench compare compares.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    fuzz::reads(path, [&] {
        const bench::Record record = bench::read_record(path);
        const bench::Comparison same = bench::compare(record, record, 0);
        fuzz::require(same.changes.size() == record.rows.size() && same.gone.empty() &&
                          same.added.empty(),
                      "rows that a record has not in common with itself");
    });
    return 0;
}

#include "host/microfacet/table_file.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

// The JSON in a table of brdfit generate, in place of that of two good ones.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string path = fuzz::folder() + "/table.exr";
    const auto parts_of = [](bool isotropic) {
        write_table(fuzz::example_table(isotropic), path);
        return read_exr_parts(path);
    };
    static const std::vector<Image> good[] = {parts_of(false), parts_of(true)};
    for (std::vector<Image> parts : good) {
        parts[0].metadata["microfacet"].assign(reinterpret_cast<const char*>(data), size);
        std::shared_ptr<const MicrofacetTable> table;
        if (fuzz::reads(path, [&] { table = table_of(std::move(parts), path); }))
            fuzz::check(*table);
    }
    return 0;
}

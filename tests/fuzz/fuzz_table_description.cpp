#include "host/files/file.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace brdfit;

// The JSON in a table of brdfit generate, in place of that of two good files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string path = fuzz::folder() + "/table.exr";
    static const std::vector<Image> good[] = {
        (write_table(fuzz::example_table(false), path), read_exr_parts(path)),
        (write_table(fuzz::example_table(true), path), read_exr_parts(path))};
    for (std::vector<Image> images : good) {
        images[0].metadata["microfacet"].assign(reinterpret_cast<const char*>(data), size);
        write_exr_parts(images, path, ExrPixel::Float);
        take_replaced_files();
        std::shared_ptr<const MicrofacetTable> table;
        if (fuzz::reads(path, [&] { table = read_table(path); }))
            fuzz::check(*table);
    }
    return 0;
}

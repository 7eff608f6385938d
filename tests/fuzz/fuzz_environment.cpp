#include "host/render/environment.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace brdfit;

// A light from all around, as a picture; and what is drawn from it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string& path = fuzz::input_file(data, size);
    Environment environment;
    if (!fuzz::reads(path, [&] { environment = read_environment(path); }))
        return 0;
    const std::size_t texels = environment.width * environment.height;
    fuzz::require(environment.width == 2 * environment.height && texels > 0 &&
                      environment.texels.size() == texels,
                  "texels of another number");
    const AliasTable table = alias_table(environment);
    fuzz::require(table.own.size() == texels && table.other.size() == texels &&
                      table.density.size() == texels,
                  "a table of another size");
    double all = 0;
    for (std::size_t i = 0; i < texels; ++i) {
        fuzz::require(table.other[i] < texels, "a texel that is none");
        fuzz::require(std::isfinite(table.density[i]) && table.density[i] >= 0,
                      "a density that is not finite");
        all += table.density[i] * environment.solid_angle(i / environment.width);
    }
    fuzz::require(std::abs(all - 1) < 1e-3, "a density whose integral is not 1");
    return 0;
}

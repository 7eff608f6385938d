#include "tests/fuzz/fuzz.hpp"

#include <cmath>
#include <fstream>

using namespace brdfit;

// Specifications beside images and tables that they may name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string path = [] {
        const std::string folder = fuzz::folder() + "/";
        fuzz::write_png(fuzz::example_image("Y"), folder + "a.png");
        write_exr(fuzz::example_image("Y"), folder + "a.exr", ExrPixel::Float);
        std::ofstream(folder + "p.csv") << "theta_h,p\n0,1\n1,0.5\n1.5,0\n";
        return folder + "spec.json";
    }();
    const std::string text(reinterpret_cast<const char*>(data), size);
    Distribution distribution;
    try {
        distribution = parse_distribution(text, path);
    } catch (const InputError&) {
        return 0; // of this file, or of one that it names
    }
    fuzz::require(!distribution.parts.empty() && distribution.parts.size() <= max_parts,
                  "a number of parts");
    for (const Share& share : distribution.shares)
        fuzz::require(share.first + share.count <= distribution.parts.size(), "a share of no part");
    for (const DistributionPart& part : distribution.parts)
        for (const double x : part.frame())
            fuzz::require(std::isfinite(x), "a frame that is not finite");
    return 0;
}

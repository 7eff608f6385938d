#include "fit/report/folder.hpp"
#include "host/files/file.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <filesystem>
#include <fstream>

using namespace brdfit;

// A folder that fit wrote, for report: of one file, the summary where it begins like one, otherwise
// a fitted material.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    const std::string path =
        fuzz::folder() + (text.rfind("file,", 0) == 0 ? "/fits.csv" : "/m.kurt.1.json");
    std::ofstream(path, std::ios::binary) << text;
    try {
        const Results results = results_of_fits(fuzz::folder(), "", {});
        fuzz::require(!results.fits.empty() || !results.failures.empty(), "results without any");
        for (const ReportedFit& fit : results.fits)
            fuzz::require(fit.material < results.materials.size(), "a fit of no material");
    } catch (const InputError& error) {
        fuzz::require(std::string(error.what()).rfind(fuzz::folder(), 0) == 0,
                      "a message without the file", error.what());
    }
    std::filesystem::remove(path);
    return 0;
}

#include "host/evaluate/measured.hpp"

#include "host/error.hpp"
#include "host/evaluate/rgl.hpp"
#include "host/measured/read.hpp"

#include <fmt/format.h>

namespace brdfit {

Evaluated evaluate_measured(const Device& device, const std::string& path,
                            const Directions& directions, const ProgressFunction& progress) {
    const MappedFile file(path);
    if (rgl::recognise(file.bytes())) {
        const RglTables tables = rgl::read_tables(file);
        return {tables.channels, evaluate(device, tables, directions, progress)};
    }
    const char* const format = measured_format(file);
    throw InputError(fmt::format(
        "{}: {} has values at its own directions only; expected an RGL .bsdf, or a material "
        "fitted to it (brdfit fit)",
        path, format == nullptr ? "the file" : format));
}

} // namespace brdfit

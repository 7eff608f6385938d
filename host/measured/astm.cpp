#include "host/measured/formats.hpp"

#include <fmt/format.h>

namespace brdfit::astm {

namespace {

/// The first word of a line, and what follows it.
std::pair<std::string_view, std::string_view> keyword(std::string_view line) {
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    return {line.substr(0, end), text::trim(line.substr(end))};
}

} // namespace

bool recognise(std::string_view bytes) {
    text::Lines lines(bytes);
    while (lines.next()) {
        const std::string_view key = keyword(lines.line()).first;
        for (const char* known : {"VARS", "NUM_POINTS", "LAB_NAME", "SAMPLE_NAME", "MEAS_NAME"})
            if (key == known)
                return true;
    }
    return false;
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    text::Lines lines(file);
    std::optional<std::size_t> points;
    while (lines.next()) {
        const auto [key, value] = keyword(lines.line());
        if (key == "NUM_POINTS")
            points = text::count(lines, key, value);
        if (key != "VARS")
            continue;
        std::vector<std::string_view> names;
        text::split(value, ',', names);
        Samples samples = scattered::read_rows(
            lines, names, {"theta_i", "phi_i", "theta_s", "phi_s"}, ',', isotropic);
        if (points && *points != samples.count())
            lines.fail_file(
                fmt::format("{} rows; expected {} as NUM_POINTS says", samples.count(), *points));
        samples.format = "ASTM E1392 text";
        return samples;
    }
    lines.fail_file("no line VARS; expected the names of the columns");
}

} // namespace brdfit::astm

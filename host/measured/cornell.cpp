#include "host/measured/formats.hpp"

#include <fmt/format.h>

namespace brdfit::cornell {

bool recognise(std::string_view bytes) {
    // The comments ahead of the first line of data tell what the numbers are.
    text::Lines lines(bytes);
    if (!lines.next())
        return false;
    const auto comments = static_cast<std::size_t>(lines.line().data() - bytes.data());
    return bytes.substr(0, comments).find("# num wls") != bytes.npos;
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    text::Lines lines(file);
    if (!lines.next())
        lines.fail_file("the file ends before the number of wavelengths");
    const std::size_t wavelengths = text::count(lines, "number of wavelengths", lines.line());
    if (wavelengths == 0)
        lines.fail("no wavelengths; expected at least one");
    std::vector<std::string_view> names{"theta_i", "phi_i", "theta_s", "phi_s"};
    const std::size_t angles = names.size();
    std::vector<std::string_view> fields;
    while (names.size() - angles < wavelengths && lines.next()) {
        text::split(lines.line(), ' ', fields);
        for (const std::string_view field : fields) {
            if (text::number(lines, "wavelength", field) <= 0)
                lines.fail(
                    fmt::format("wavelength {}; expected a positive number", text::quoted(field)));
            names.push_back(field);
        }
    }
    if (names.size() - angles != wavelengths)
        lines.fail(fmt::format("{} wavelengths; expected {}", names.size() - angles, wavelengths));
    Samples samples = scattered::read_rows(lines, names, {"theta_i", "phi_i", "theta_s", "phi_s"},
                                           ' ', isotropic);
    samples.format = "Cornell spectral text";
    return samples;
}

} // namespace brdfit::cornell

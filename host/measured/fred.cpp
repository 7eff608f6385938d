#include "host/error.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/rows.hpp"

#include <cfloat>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::fred {

namespace {

/// What the line `format` says of the numbers.
struct Units {
    double angle = degree; ///< radians
    double scale = 1;      ///< of values, to 1/sr
};

Units read_units(const text::Lines& lines, const std::vector<std::string_view>& words) {
    Units units;
    for (std::size_t i = 1; i < words.size(); ++i) {
        const std::size_t equals = std::min(words[i].find('='), words[i].size());
        const std::string_view key = words[i].substr(0, equals);
        const std::string_view value = words[i].substr(std::min(equals + 1, words[i].size()));
        if (key == "angles" && (value == "deg" || value == "rad"))
            units.angle = value == "deg" ? degree : 1;
        else if (key == "scale")
            units.scale = text::number(lines, key, value);
        else if (key != "bsdf" || value != "value")
            lines.fail(fmt::format("{}; expected angles=deg, angles=rad, bsdf=value or scale=",
                                   text::quoted(words[i])));
    }
    return units;
}

/// Theta, phi and a value.
bool is_row(const std::vector<std::string_view>& words) {
    return words.size() == 3 && words[0] != "format";
}

} // namespace

bool recognise(std::string_view bytes) {
    text::Lines lines(bytes);
    std::vector<std::string_view> words;
    if (lines.next())
        text::split(lines.line(), ' ', words);
    return words.size() == 2 && words[0] == "type" && words[1] == "bsdf_data";
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    text::Lines lines(file);
    lines.next(); // type bsdf_data
    std::vector<std::string_view> words;
    Units units;
    const std::size_t count = lines.ahead([&](std::string_view line) {
        text::split(line, ' ', words);
        return is_row(words);
    });
    if (count == 0)
        lines.fail_file("no samples; expected rows of theta, phi and a value");
    Rows rows(lines, numbered_channels(1), count);
    std::optional<Vector> wi;
    std::optional<double> first_phi;
    bool one_plane = true;
    const auto polar = [&](std::string_view what, std::string_view field) {
        const double theta = text::number(lines, what, field) * units.angle;
        if (std::abs(theta) > pi / 2 + scattered::theta_tolerance)
            lines.fail(fmt::format("{}: {}; expected an angle within a quarter turn", what,
                                   text::quoted(field)));
        return std::max(-pi / 2, std::min(theta, pi / 2));
    };
    while (lines.next()) {
        text::split(lines.line(), ' ', words);
        if (words[0] == "format") {
            units = read_units(lines, words);
        } else if (words.size() == 2) {
            // The specular direction: the light is on the other side.
            const double theta = polar("incident theta", words[0]);
            const double phi = text::number(lines, "incident phi", words[1]) * units.angle;
            wi = direction(theta, phi + pi);
            one_plane = one_plane && phi == first_phi.value_or(phi);
            first_phi = phi;
        } else if (is_row(words)) {
            if (!wi)
                lines.fail("a value ahead of its incident direction; expected theta and phi");
            const double theta = polar("theta", words[0]);
            const double phi = text::number(lines, "phi", words[1]) * units.angle;
            const double value = text::number(lines, "value", words[2]) * units.scale;
            if (!(std::abs(value) <= FLT_MAX))
                lines.fail(fmt::format("value: {} is too large", text::quoted(words[2])));
            rows.add(*wi, direction(theta, phi));
            rows.add_value(static_cast<float>(value));
        } else {
            lines.fail(fmt::format("{} numbers; expected the incident theta and phi, or theta, "
                                   "phi and a value",
                                   words.size()));
        }
    }
    return rows.samples("FRED BSDF text", isotropic.value_or(one_plane));
}

} // namespace brdfit::fred

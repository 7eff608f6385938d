#include "host/measured/formats.hpp"

#include "host/files/channels.hpp"
#include "host/measured/rows.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <fmt/format.h>
#include <unordered_set>

namespace brdfit::scattered {

namespace {

constexpr double half_pi = 1.57079632679489661923;
const Angles csv_angles{"theta_i", "phi_i", "theta_o", "phi_o"};

void require_distinct(const text::Lines& lines, const std::vector<std::string_view>& names) {
    std::unordered_set<std::string_view> seen;
    for (const std::string_view name : names) {
        if (name.empty())
            lines.fail("a column has no name");
        if (!seen.insert(name).second)
            lines.fail(fmt::format("two columns are named {}", text::quoted(name)));
    }
}

std::size_t find_column(const text::Lines& lines, const std::vector<std::string_view>& names,
                        const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
        lines.fail(fmt::format("column '{}' is missing", name));
    return static_cast<std::size_t>(found - names.begin());
}

/// A polar angle of a row: within the hemisphere.
double polar_angle(const text::Lines& lines, std::string_view column, std::string_view field) {
    const double theta = text::number(lines, column, field);
    if (theta < 0 || theta > half_pi + theta_tolerance)
        lines.fail(fmt::format("column {}: {}; expected an angle in [0, pi/2] radians", column,
                               text::quoted(field)));
    return std::min(theta, half_pi);
}

float float_number(const text::Lines& lines, std::string_view column, std::string_view field) {
    const double value = text::number(lines, column, field);
    if (std::abs(value) > FLT_MAX)
        lines.fail(fmt::format("column {}: {} is too large", column, text::quoted(field)));
    return static_cast<float>(value);
}

/// The fields of the first line of the text that is neither blank nor a comment.
std::vector<std::string_view> first_fields(text::Lines& lines) {
    std::vector<std::string_view> fields;
    if (lines.next())
        text::split(lines.line(), ',', fields);
    return fields;
}

} // namespace

Samples read_rows(text::Lines& lines, const std::vector<std::string_view>& names,
                  const Angles& angles, char separator, std::optional<bool> isotropic) {
    require_distinct(lines, names);
    const std::size_t theta_i = find_column(lines, names, angles.theta_i);
    const std::size_t phi_i = find_column(lines, names, angles.phi_i);
    const std::size_t theta_o = find_column(lines, names, angles.theta_o);
    const std::size_t phi_o = find_column(lines, names, angles.phi_o);
    const auto weight_name = std::find(names.begin(), names.end(), "weight");
    const bool weighted = weight_name != names.end();
    const auto weight = static_cast<std::size_t>(weight_name - names.begin());
    std::vector<std::size_t> channels;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (i != theta_i && i != phi_i && i != theta_o && i != phi_o && !(weighted && i == weight))
            channels.push_back(i);
    if (channels.empty())
        lines.fail("no column holds values; expected one for each channel");
    if (channels.size() > max_channels)
        lines.fail(fmt::format("{} channels; expected at most {}", channels.size(), max_channels));
    for (const std::size_t i : channels)
        if (!is_channel_name(names[i]))
            lines.fail(fmt::format("column {}: {}; expected {}", i + 1, text::quoted(names[i]),
                                   channel_name_expected));

    std::vector<std::string> channel_names;
    for (const std::size_t i : channels)
        channel_names.emplace_back(names[i]);
    const std::size_t count = lines.rows_ahead(names.size());
    Rows rows(lines, std::move(channel_names), count, weighted);
    std::optional<double> first_phi;
    bool one_plane = true;
    std::vector<std::string_view> fields;
    while (lines.next()) {
        text::split(lines.line(), separator, fields);
        if (fields.size() != names.size())
            lines.fail(fmt::format("{} fields; expected {}", fields.size(), names.size()));
        const double theta = polar_angle(lines, angles.theta_i, fields[theta_i]),
                     phi = text::number(lines, angles.phi_i, fields[phi_i]);
        rows.add(direction(theta, phi),
                 direction(polar_angle(lines, angles.theta_o, fields[theta_o]),
                           text::number(lines, angles.phi_o, fields[phi_o])));
        one_plane = one_plane && phi == first_phi.value_or(phi);
        first_phi = phi;
        for (const std::size_t i : channels)
            rows.add_value(float_number(lines, names[i], fields[i]));
        if (!weighted)
            continue;
        const float value = float_number(lines, names[weight], fields[weight]);
        if (value < 0)
            lines.fail(
                fmt::format("column weight: {}; expected 0 or more", text::quoted(fields[weight])));
        rows.add_weight(value);
    }
    if (count == 0)
        lines.fail_file("no samples; expected rows of numbers after the header");
    return rows.samples({}, isotropic.value_or(one_plane));
}

bool recognise(std::string_view bytes) {
    text::Lines lines(bytes);
    const std::vector<std::string_view> fields = first_fields(lines);
    return std::any_of(fields.begin(), fields.end(), [](std::string_view field) {
        return field == csv_angles.theta_i || field == csv_angles.phi_i ||
               field == csv_angles.theta_o || field == csv_angles.phi_o;
    });
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    text::Lines lines(file);
    Samples samples = read_rows(lines, first_fields(lines), csv_angles, ',', isotropic);
    samples.format = "scattered CSV";
    return samples;
}

} // namespace brdfit::scattered

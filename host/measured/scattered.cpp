#include "host/measured/formats.hpp"

#include "host/files/channels.hpp"

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

    struct Pair {
        double theta_i, phi_i, theta_o, phi_o;
    };
    std::vector<Pair> pairs;
    std::vector<float> rows; // [sample][channel]: how many samples there are shows at the end
    Samples samples;
    std::vector<std::string_view> fields;
    while (lines.next()) {
        text::split(lines.line(), separator, fields);
        if (fields.size() != names.size())
            lines.fail(fmt::format("{} fields; expected {}", fields.size(), names.size()));
        pairs.push_back({polar_angle(lines, angles.theta_i, fields[theta_i]),
                         text::number(lines, angles.phi_i, fields[phi_i]),
                         polar_angle(lines, angles.theta_o, fields[theta_o]),
                         text::number(lines, angles.phi_o, fields[phi_o])});
        for (const std::size_t i : channels)
            rows.push_back(float_number(lines, names[i], fields[i]));
        if (weighted) {
            samples.weights.push_back(float_number(lines, names[weight], fields[weight]));
            if (samples.weights.back() < 0)
                lines.fail(fmt::format("column weight: {}; expected 0 or more",
                                       text::quoted(fields[weight])));
        }
    }
    if (pairs.empty())
        lines.fail_file("no samples; expected rows of numbers after the header");

    Directions directions(pairs.size());
    samples.values.resize(rows.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        directions.set(k, direction(pairs[k].theta_i, pairs[k].phi_i),
                       direction(pairs[k].theta_o, pairs[k].phi_o));
        for (std::size_t c = 0; c < channels.size(); ++c)
            samples.values[c * pairs.size() + k] = rows[k * channels.size() + c];
    }
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    for (const std::size_t i : channels)
        samples.channels.emplace_back(names[i]);
    samples.valid.assign(pairs.size(), 1);
    samples.isotropic =
        isotropic.value_or(std::all_of(pairs.begin(), pairs.end(), [&](const Pair& pair) {
            return pair.phi_i == pairs[0].phi_i;
        }));
    return samples;
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

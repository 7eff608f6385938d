#include "host/measured/kind.hpp"

#include "host/error.hpp"
#include "host/files/json.hpp"
#include "host/files/npy.hpp"
#include "host/files/text.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace brdfit {

namespace {

constexpr std::size_t most_json = std::size_t{16} << 20;

/// The keys of the object that a text is, as far as it can be read; nothing else of it is kept.
std::set<std::string> keys_of(std::string_view text) {
    std::set<std::string> keys;
    const auto keep = [&](int depth, Json::parse_event_t event, const Json& parsed) {
        if (event == Json::parse_event_t::key && depth == 1 && keys.size() < max_json_keys)
            keys.insert(parsed.get<std::string>());
        return depth == 0;
    };
    const Json ignored = Json::parse(text, keep, false);
    return keys;
}

Recognised recognised_json(std::string_view bytes) {
    if (bytes.size() > most_json)
        return {};
    const std::set<std::string> keys = keys_of(bytes);
    const auto has = [&](const char* key) { return keys.count(key) > 0; };
    if (has("lobes") || (has("brdfit") && has("diffuse")))
        return {FileKind::Material, "a material"};
    if (has("axes"))
        return {FileKind::TableSpec, "a table's specification"};
    if (has("distribution") && !has("energy"))
        return {FileKind::Distribution, "a distribution's specification"};
    return {};
}

Recognised recognised_npy(const MappedFile& file) {
    std::size_t columns = 0;
    try {
        columns = npy::read(file).columns;
    } catch (const InputError&) {
        return {FileKind::Unknown, "a NumPy array"};
    }
    if (columns == 3 || columns == 6)
        return {FileKind::Directions, "a NumPy array of directions"};
    if (columns > 7)
        return {FileKind::Measurement, "a measurement (NumPy array)"};
    return {FileKind::Unknown, fmt::format("a NumPy array of {} columns", columns)};
}

} // namespace

Recognised recognised(const MappedFile& file) {
    const std::string_view bytes = file.bytes(), head = bytes.substr(0, 1 << 16);
    const auto begins = [&](std::string_view with) { return head.substr(0, with.size()) == with; };
    if (npy::recognise(head))
        return recognised_npy(file);
    if (begins("\x76\x2f\x31\x01")) {
        const bool table = head.find(std::string_view("microfacet\0string", 17)) != head.npos;
        return {table ? FileKind::Table : FileKind::Picture,
                table ? "a distribution's table (OpenEXR)" : "an OpenEXR image"};
    }
    if (begins("\x89PNG"))
        return {FileKind::Picture, "a PNG image"};
    if (const char* const format = measured_format(file))
        return {FileKind::Measurement, fmt::format("a measurement ({})", format)};
    text::Lines lines(head);
    if (!lines.next())
        return {};
    if (lines.line()[0] == '{')
        return recognised_json(bytes);
    if (lines.line().substr(0, 4) == "<svg" || lines.line().substr(0, 5) == "<?xml")
        return {FileKind::Picture, "an SVG image"};
    std::vector<std::string_view> names;
    text::split(lines.line(), ',', names);
    for (const char* name : {"wi_x", "wo_x"})
        if (std::find(names.begin(), names.end(), name) != names.end())
            return {FileKind::Directions, "a table of directions (CSV)"};
    return {};
}

std::string name_of(FileKind kind) {
    switch (kind) {
    case FileKind::Measurement:
        return "a measurement";
    case FileKind::Material:
        return "a material file";
    case FileKind::Distribution:
        return "a distribution's specification (.json)";
    case FileKind::TableSpec:
        return "a table's specification (.json)";
    case FileKind::Directions:
        return "directions: .csv with wi_x,wi_y,wi_z,wo_x,wo_y,wo_z or .npy of shape (N, 6)";
    case FileKind::Table:
        return "a distribution's table (.exr)";
    case FileKind::Picture:
        return "an image";
    case FileKind::Unknown:
        break;
    }
    return "something else";
}

} // namespace brdfit

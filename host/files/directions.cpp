#include "host/files/directions.hpp"

#include "host/error.hpp"
#include "host/files/npy.hpp"
#include "host/files/text.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace brdfit {

namespace {

constexpr const char* direction_columns[] = {"wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"};

struct Pair {
    Vector wi, wo;
};

/// The pair of unit vectors in a row wi_x,wi_y,wi_z,wo_x,wo_y,wo_z; calls fail(message) if there is
/// none.
template <typename Fail>
Pair to_pair(const std::array<double, 6>& row, const Fail& fail) {
    Pair pair;
    if (!normalise(row.data(), pair.wi))
        fail("wi is not a unit vector");
    if (!normalise(row.data() + 3, pair.wo))
        fail("wo is not a unit vector");
    return pair;
}

Directions read_npy_directions(const MappedFile& file) {
    const npy::Array table = npy::read(file);
    if (table.columns != 6 || table.rows == 0)
        throw InputError(fmt::format("{}: {} rows of {} columns; expected at least one row of 6",
                                     file.path(), table.rows, table.columns));
    Directions directions(table.rows);
    for (std::size_t k = 0; k < table.rows; ++k) {
        std::array<double, 6> row;
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] = table.at(k, i);
        const Pair pair = to_pair(row, [&](const char* message) {
            throw InputError(fmt::format("{}: row {}: {}", file.path(), k, message));
        });
        directions.set(k, pair.wi, pair.wo);
    }
    return directions;
}

/// `lines` stands at the header.
Directions read_csv_directions(text::Lines& lines) {
    std::vector<std::string_view> fields;
    text::split(lines.line(), ',', fields);
    std::array<std::size_t, 6> column;
    for (std::size_t i = 0; i < column.size(); ++i) {
        const auto found = std::find(fields.begin(), fields.end(), direction_columns[i]);
        if (found == fields.end())
            lines.fail(fmt::format("column '{}' is missing", direction_columns[i]));
        column[i] = static_cast<std::size_t>(found - fields.begin());
    }
    if (fields.size() != column.size())
        lines.fail(
            fmt::format("{} columns; expected wi_x,wi_y,wi_z,wo_x,wo_y,wo_z only", fields.size()));
    std::vector<Pair> pairs;
    while (lines.next()) {
        text::split(lines.line(), ',', fields);
        if (fields.size() != column.size())
            lines.fail(fmt::format("{} fields; expected {}", fields.size(), column.size()));
        std::array<double, 6> row;
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] = text::number(lines, direction_columns[i], fields[column[i]]);
        pairs.push_back(to_pair(row, [&](const char* message) { lines.fail(message); }));
    }
    if (pairs.empty())
        lines.fail_file("no directions; expected rows of numbers after the header");
    Directions directions(pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k)
        directions.set(k, pairs[k].wi, pairs[k].wo);
    return directions;
}

} // namespace

Directions read_directions(const std::string& path) {
    const MappedFile file(path);
    if (npy::recognise(file.bytes()))
        return read_npy_directions(file);
    text::Lines lines(file);
    if (lines.next())
        for (const char* name : direction_columns)
            if (lines.line().find(name) != std::string_view::npos)
                return read_csv_directions(lines);
    throw InputError(fmt::format("{}: unknown format; expected CSV with the header "
                                 "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z or .npy of shape (N, 6)",
                                 path));
}

std::vector<Vector> read_viewers(const std::string& path) {
    const MappedFile file(path);
    std::vector<Vector> viewers;
    const auto add = [&](const std::array<double, 3>& row, const auto& fail) {
        Vector wo;
        if (!normalise(row.data(), wo))
            fail("wo is not a unit vector");
        if (!(static_cast<float>(wo[2]) > 0))
            fail("wo is not above the horizon; expected wo_z above 0");
        viewers.push_back(wo);
    };
    if (npy::recognise(file.bytes())) {
        const npy::Array table = npy::read(file);
        if ((table.columns != 3 && table.columns != 6) || table.rows == 0)
            throw InputError(
                fmt::format("{}: {} rows of {} columns; expected at least one row of 3 "
                            "(wo) or 6 (wi, wo)",
                            path, table.rows, table.columns));
        for (std::size_t k = 0; k < table.rows; ++k) {
            const std::size_t wo = table.columns - 3;
            add({table.at(k, wo), table.at(k, wo + 1), table.at(k, wo + 2)},
                [&](const char* message) {
                    throw InputError(fmt::format("{}: row {}: {}", path, k, message));
                });
        }
        return viewers;
    }
    text::Lines lines(file);
    std::vector<std::string_view> fields;
    if (lines.next())
        text::split(lines.line(), ',', fields);
    std::array<std::size_t, 3> column{};
    for (std::size_t i = 0; i < column.size(); ++i) {
        const auto found = std::find(fields.begin(), fields.end(), direction_columns[3 + i]);
        if (found == fields.end())
            throw InputError(fmt::format("{}: unknown format; expected CSV with the columns "
                                         "wo_x,wo_y,wo_z or .npy of shape (N, 3) or (N, 6)",
                                         path));
        column[i] = static_cast<std::size_t>(found - fields.begin());
    }
    const std::size_t columns = fields.size();
    while (lines.next()) {
        text::split(lines.line(), ',', fields);
        if (fields.size() != columns)
            lines.fail(fmt::format("{} fields; expected {}", fields.size(), columns));
        std::array<double, 3> row;
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] = text::number(lines, direction_columns[3 + i], fields[column[i]]);
        add(row, [&](const char* message) { lines.fail(message); });
    }
    if (viewers.empty())
        lines.fail_file("no directions; expected rows of numbers after the header");
    return viewers;
}

} // namespace brdfit

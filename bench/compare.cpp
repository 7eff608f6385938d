#include "bench/compare.hpp"

#include "host/files/json.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace brdfit::bench {

namespace {

/// The rows by what names them, of equal ones the first.
using Places = std::map<std::tuple<std::string, std::string, std::string, int>, const Record::Row*>;

auto place_of(const Record::Row& row) {
    return std::tuple(row.device, row.work, row.model, row.threads);
}

Places places_of(const Record& record) {
    Places places;
    for (const Record::Row& row : record.rows)
        places.emplace(place_of(row), &row);
    return places;
}

Record::Row row_of(const Json& json, const Place& at) {
    check_object(json, at, "an object");
    const auto text = [&](const char* key) {
        return parse_text(required(json, at, key, "a text"), at.member(key), "a text");
    };
    const auto number = [&](const char* key, double lower, double upper) {
        return parse_number(required(json, at, key, "a number"), at.member(key), lower, upper);
    };
    constexpr double least = std::numeric_limits<double>::min();
    constexpr double most = std::numeric_limits<double>::max();
    return {text("device"),
            text("work"),
            text("model"),
            static_cast<int>(number("threads", 0, std::numeric_limits<int>::max())),
            number("samples_per_second", least, most),
            number("spread", 0, most)};
}

} // namespace

Record read_record(const std::string& path) {
    constexpr std::size_t most_bytes = std::size_t{64} << 20;
    const std::string expected = "what brdfit bench --json writes, an object with a list 'results'";
    const Json json = read_json(path, expected, most_bytes);
    const Place top{path, ""};
    check_object(json, top, expected);
    const Json& results = required(json, top, "results", "a list");
    if (!results.is_array())
        top.member("results").fail(results, "a list");
    Record record;
    for (const auto& [key, text] :
         {std::pair{"machine", &record.machine}, std::pair{"version", &record.version}})
        if (const Json* const value = optional(json, key))
            *text = parse_text(*value, top.member(key), "a text");
    for (std::size_t i = 0; i < results.size(); ++i)
        record.rows.push_back(row_of(results[i], top.member("results").element(i)));
    return record;
}

Comparison compare(const Record& before, const Record& after, double least) {
    Comparison comparison;
    const Places in_before = places_of(before), in_after = places_of(after);
    for (const Record::Row& row : before.rows) {
        const auto other = in_after.find(place_of(row));
        if (other == in_after.end())
            comparison.gone.push_back(row);
        else
            comparison.changes.push_back(
                {row, *other->second, std::max(least, row.spread + other->second->spread)});
    }
    for (const Record::Row& row : after.rows)
        if (in_before.count(place_of(row)) == 0)
            comparison.added.push_back(row);
    return comparison;
}

} // namespace brdfit::bench

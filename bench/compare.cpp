#include "bench/compare.hpp"

#include "host/error.hpp"
#include "host/files/json.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <tuple>

namespace brdfit::bench {

namespace {

bool same_place(const Record::Row& a, const Record::Row& b) {
    return std::tie(a.device, a.work, a.model, a.threads) ==
           std::tie(b.device, b.work, b.model, b.threads);
}

const Record::Row* find(const std::vector<Record::Row>& rows, const Record::Row& wanted) {
    const auto found = std::find_if(
        rows.begin(), rows.end(), [&](const Record::Row& row) { return same_place(row, wanted); });
    return found == rows.end() ? nullptr : &*found;
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
    std::size_t index = 0;
    try {
        record.machine = json.value("machine", "");
        record.version = json.value("version", "");
        for (const auto& row : results) {
            record.rows.push_back({row.at("device"), row.at("work"), row.at("model"),
                                   row.at("threads"), row.at("samples_per_second"),
                                   row.at("spread")});
            const Record::Row& r = record.rows.back();
            if (!(std::isfinite(r.samples_per_second) && r.samples_per_second > 0 &&
                  std::isfinite(r.spread) && r.spread >= 0))
                throw InputError(fmt::format("{}: results[{}]: expected a positive "
                                             "samples_per_second and a spread of at least 0",
                                             path, index));
            ++index;
        }
    } catch (const Json::exception& error) {
        throw InputError(fmt::format("{}: results[{}]: expected device, work, model, threads, "
                                     "samples_per_second and spread ({})",
                                     path, index, error.what()));
    }
    return record;
}

Comparison compare(const Record& before, const Record& after, double least) {
    Comparison comparison;
    for (const Record::Row& row : before.rows) {
        const Record::Row* const other = find(after.rows, row);
        if (other == nullptr)
            comparison.gone.push_back(row);
        else
            comparison.changes.push_back(
                {row, *other, std::max(least, row.spread + other->spread)});
    }
    for (const Record::Row& row : after.rows)
        if (find(before.rows, row) == nullptr)
            comparison.added.push_back(row);
    return comparison;
}

} // namespace brdfit::bench

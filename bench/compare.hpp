#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace brdfit::bench {

/// What `brdfit bench --json` wrote, as far as comparisons need it.
struct Record {
    struct Row {
        std::string device, work, model;
        int threads;
        double samples_per_second, spread;
    };
    std::string machine, version;
    std::vector<Row> rows;
};
/// Throws InputError naming the file and the row where it is none of these files.
Record read_record(const std::string& path);

/// A row of both records.
struct Change {
    Record::Row before, after;
    double change() const { return after.samples_per_second / before.samples_per_second - 1; }
    /// What chance may make of equal speeds: the spreads of both together, at least `least`.
    double noise;
    bool slower() const { return change() < 0 && 1 / (1 + change()) - 1 > noise; }
    bool faster() const { return change() > noise; }
};

struct Comparison {
    std::vector<Change> changes;          ///< in the order of `before`
    std::vector<Record::Row> gone, added; ///< rows of one of them alone
};
Comparison compare(const Record& before, const Record& after, double least);

} // namespace brdfit::bench

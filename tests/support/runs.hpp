#pragma once

#include "fit/runs/log.hpp"
#include "tests/support/cli.hpp"

#include <string>
#include <vector>

// What the tests of runs share.

namespace brdfit::test {

/// The rows of a query on an SQLite file, columns with '|' between.
std::vector<std::string> query(const std::string& database, const std::string& sql);

/// A folder with small measurements a.csv, b.csv and c.csv, and the run that is planned in it.
class Runs : public testing::Test {
  protected:
    explicit Runs(int samples = 200);

    /// `brdfit plan` of the three files into the folder `run`, with these options besides. Expects
    /// that it succeeds.
    void plan(const std::vector<std::string>& options = {"-m", "lambert,ward,kurt"},
              const std::string& run = "run");
    /// `brdfit run` there.
    Outcome run(const std::vector<std::string>& options = {}, const std::string& run = "run",
                const std::vector<std::string>& environment = {});
    /// What `brdfit merge` makes of it: every column of fits but the times and who made them, then
    /// of parameters. Expects that it succeeds.
    std::vector<std::string> merged(const std::string& run = "run");
    /// The log of the only shard, or of another.
    std::string log(const std::string& shard = "0-of-1", const std::string& run = "run") const;

    TemporaryFolder folder;
};

/// "ID" for each line "done ID" that a run with --verbose said.
std::vector<std::string> told_done(const Outcome& outcome);

} // namespace brdfit::test

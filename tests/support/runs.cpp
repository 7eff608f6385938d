#include "tests/support/runs.hpp"

#include <fmt/format.h>
#include <memory>
#include <sqlite3.h>
#include <sstream>
#include <stdexcept>

namespace brdfit::test {

std::vector<std::string> query(const std::string& database, const std::string& sql) {
    sqlite3* opened = nullptr;
    const int status = sqlite3_open_v2(database.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    const std::unique_ptr<sqlite3, int (*)(sqlite3*)> close(opened, sqlite3_close);
    std::vector<std::string> rows;
    const auto add = [](void* to, int columns, char** values, char**) {
        std::string row;
        for (int i = 0; i < columns; ++i)
            row += (i == 0 ? "" : "|") + std::string(values[i] != nullptr ? values[i] : "NULL");
        static_cast<std::vector<std::string>*>(to)->push_back(row);
        return 0;
    };
    if (status != SQLITE_OK || sqlite3_exec(opened, sql.c_str(), add, &rows, nullptr) != SQLITE_OK)
        throw std::runtime_error(database + ": " + sqlite3_errmsg(opened));
    return rows;
}

Runs::Runs(int samples) {
    write_file(folder / "paint.json", R"({"brdfit": 1, "channels": ["R", "G"],
        "diffuse": {"model": "lambert", "kd": [0.1, 0.3]},
        "lobes": [{"model": "kurt", "ks": [0.5, 0.3], "f0": 0.5, "m": 0.2, "alpha": 0.1}]})");
    for (const char* name : {"a", "b", "c"}) {
        const Outcome made = run_program(
            {"synth", folder / "paint.json", folder / (std::string(name) + ".csv"), "--directions",
             std::to_string(samples), "--noise", "0.02", "--seed", std::to_string(*name)});
        if (made.status != 0)
            throw std::runtime_error(made.err);
    }
}

void Runs::plan(const std::vector<std::string>& options, const std::string& run) {
    std::vector<std::string> arguments{"plan", folder / "a.csv", folder / "b.csv", folder / "c.csv",
                                       "-o",   folder / run};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome outcome = run_program(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
}

Outcome Runs::run(const std::vector<std::string>& options, const std::string& run,
                  const std::vector<std::string>& environment) {
    std::vector<std::string> arguments{"run", folder / run};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_program(arguments, environment);
}

std::vector<std::string> Runs::merged(const std::string& run) {
    const std::string database = folder / (run + ".sqlite");
    const Outcome outcome = run_program({"merge", folder / run, "-o", database});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    if (outcome.status != 0)
        return {};
    std::vector<std::string> rows = query(
        database,
        "SELECT fit, task, file, path, model, lobes, diffuse, metric, state, failed, error, "
        "error_ngan, error_l2, error_log, error_cbrt, samples, evaluations, thinned_evaluations, "
        "starts, random_starts_better, largest_albedo, largest_albedo_theta, "
        "largest_albedo_channel, remarks, device, driver, form, kernels, version, "
        "algorithm_version, material_file, json_remove(material, '$.fit.seconds') FROM fits");
    for (std::string& row : query(database, "SELECT * FROM parameters"))
        rows.push_back(std::move(row));
    return rows;
}

std::string Runs::log(const std::string& shard, const std::string& run) const {
    return folder / (run + "/shards/" + shard + ".jsonl");
}

std::vector<std::string> told_done(const Outcome& outcome) {
    const std::string before = "brdfit: debug: done ";
    std::vector<std::string> ids;
    std::istringstream lines(outcome.err);
    // A last line that is not ended was not told.
    for (std::string line; std::getline(lines, line) && !lines.eof();)
        if (line.rfind(before, 0) == 0)
            ids.push_back(line.substr(before.size(), 64));
    return ids;
}

} // namespace brdfit::test

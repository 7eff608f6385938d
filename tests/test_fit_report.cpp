// What a fit leaves for people and programs: nothing is replaced unasked, a failure is a row of its
// own, the summary is one table, and what is doubtful is said.

#include "fit/report.hpp"
#include "host/device/kernels.hpp"
#include "host/device/tuning.hpp"
#include "host/files/json.hpp"
#include "tests/support/cli.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

namespace brdfit {

namespace {

using namespace test;
using nlohmann::json;

using CsvRow = std::map<std::string, std::string>;

/// The rows of a CSV text by the names of their columns, quotes as in RFC 4180. Every row has as
/// many fields as there are names.
std::vector<CsvRow> csv_rows(const std::string& text) {
    std::vector<Names> table(1, Names(1));
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
            table.back().back() += text[++i];
        else if (c == '"')
            quoted = !quoted;
        else if (!quoted && c == ',')
            table.back().emplace_back();
        else if (!quoted && c == '\n')
            table.emplace_back(1);
        else
            table.back().back() += c;
    }
    EXPECT_FALSE(quoted);
    EXPECT_EQ(table.back(), Names(1)) << "the last line is not ended";
    table.pop_back();
    std::vector<CsvRow> rows;
    for (std::size_t r = 1; r < table.size(); ++r) {
        EXPECT_EQ(table[r].size(), table[0].size()) << "row " << r;
        CsvRow row;
        for (std::size_t i = 0; i < std::min(table[r].size(), table[0].size()); ++i)
            EXPECT_TRUE(row.emplace(table[0][i], table[r][i]).second) << table[0][i] << " twice";
        rows.push_back(row);
    }
    return rows;
}

/// As in Cli, without --force.
Outcome fit_paint(const TemporaryFolder& folder, const std::vector<std::string>& options,
                  const std::vector<std::string>& environment = {}) {
    std::vector<std::string> arguments{"fit", folder / "paint.csv", "-o", folder / "out"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_program(arguments, environment);
}

/// A kernel of Kurt's that does not build: one structure's fits fail.
KernelFolder broken_kurt() {
    return KernelFolder("models/kurt.cl", "const float alpha", "no_such_type alpha");
}

TEST_F(Cli, fit_replaces_materials_only_with_force) {
    ASSERT_EQ(fit_paint(folder, {"-m", "ward"}).status, 0);
    write_file(folder / "out/paint.ward.1.json", "precious");
    const Outcome refused = fit_paint(folder, {"-m", "lambert,ward"});
    expect_input_error(refused, "paint.ward.1.json is there already");
    EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
    EXPECT_EQ(refused.out, "");
    EXPECT_EQ(read_file(folder / "out/paint.ward.1.json"), "precious");
    EXPECT_EQ(out_names(), Names{"paint.ward.1.json"}) << "nothing is fitted before the refusal";
    ASSERT_EQ(fit_paint(folder, {"-m", "lambert,ward", "--force"}).status, 0);
    EXPECT_NO_THROW(written("paint.ward.1.json"));
    expect_input_error(fit_paint(folder, {"-m", "lambert,ward"}), "and 1 more are there already");
}

TEST_F(Cli, fit_replaces_a_summary_only_with_force) {
    write_file(folder / "summary.csv", "precious");
    const std::vector<std::string> options{"-m", "ward", "--csv", folder / "summary.csv"};
    expect_input_error(fit_paint(folder, options), "summary.csv is there already");
    EXPECT_EQ(read_file(folder / "summary.csv"), "precious");
    EXPECT_EQ(out_names(), Names{});
    std::vector<std::string> forced = options;
    forced.emplace_back("--force");
    ASSERT_EQ(fit_paint(folder, forced).status, 0);
    EXPECT_EQ(csv_rows(read_file(folder / "summary.csv")).size(), 1U);
}

TEST_F(Cli, lobes_that_no_model_asked_for_can_have_are_wrong_usage) {
    expect_usage_error(fit({"-m", "kurt+ward", "--lobes", "2,3"}), "--lobes 3");
    expect_usage_error(fit({"-m", "kurt+ward", "--lobes", "1"}), "--lobes 1");
    EXPECT_EQ(out_names(), Names{});
    EXPECT_EQ(fit({"-m", "lambert+ward", "--lobes", "1"}).status, 2);
    EXPECT_EQ(fit({"-m", "kurt+ward,ward", "--lobes", "1,2"}).status, 0);
}

TEST_F(Cli, one_failing_structure_does_not_drop_the_rest_of_its_file) {
    const KernelFolder kernels = broken_kurt();
    const Outcome outcome =
        fit_paint(folder, {"-m", "kurt,ward,lambert", "--json", "--csv", folder / "summary.csv"},
                  {"BRDFIT_KERNELS=" + kernels.path().string()});
    expect_input_error(outcome, "paint.csv: kurt 1: ");
    EXPECT_EQ(out_names(), (Names{"paint.lambert.0.json", "paint.ward.1.json"}));
    std::map<std::string, json> rows;
    for (const json& row : json::parse(outcome.out))
        rows[row["model"]] = row;
    ASSERT_EQ(rows.size(), 3U) << outcome.out;
    EXPECT_FALSE(rows["ward"].contains("failed"));
    EXPECT_EQ(rows["kurt"]["file"], folder / "paint.csv");
    EXPECT_EQ(rows["kurt"]["lobes"], 1);
    const std::string reason = rows["kurt"]["failed"];
    EXPECT_NE(reason.find("kurt.cl"), std::string::npos) << reason;
    std::map<std::string, CsvRow> summary;
    for (const CsvRow& row : csv_rows(read_file(folder / "summary.csv")))
        summary[row.at("model")] = row;
    ASSERT_EQ(summary.size(), 3U);
    EXPECT_EQ(summary["kurt"]["failed"], reason);
    EXPECT_EQ(summary["kurt"]["file"], folder / "paint.csv");
    EXPECT_EQ(summary["kurt"]["lobes"], "1");
    EXPECT_EQ(summary["kurt"]["error_ngan"], "");
    EXPECT_EQ(summary["kurt"]["l1_m"], "");
    EXPECT_EQ(summary["ward"]["failed"], "");
    EXPECT_NE(summary["ward"]["l1_m"], "");
}

TEST_F(Cli, a_file_that_cannot_be_read_is_a_row_with_its_reason) {
    const Outcome outcome =
        run_program({"fit", folder / "missing.csv", folder / "paint.csv", "-m", "ward", "-o",
                     folder / "out", "--json", "--csv", folder / "summary.csv"});
    EXPECT_EQ(outcome.status, 1);
    const json rows = json::parse(outcome.out);
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[1]["file"], folder / "missing.csv");
    EXPECT_FALSE(rows[1].contains("model"));
    const std::vector<CsvRow> summary = csv_rows(read_file(folder / "summary.csv"));
    ASSERT_EQ(summary.size(), 2U);
    EXPECT_EQ(summary[1].at("file"), folder / "missing.csv");
    EXPECT_EQ(summary[1].at("failed"), rows[1]["failed"]);
    EXPECT_EQ(summary[1].at("model"), "");
}

TEST_F(Cli, a_material_records_all_that_its_fit_depends_on) {
    ASSERT_EQ(fit({"-m", "kurt", "--starts", "2", "--seed", "7", "--fix", "1.f0=0.25", "--bound",
                   "m=0.1:1"})
                  .status,
              0);
    const auto record = written("paint.kurt.1.json").fit;
    EXPECT_EQ(record["starts"], 2);
    EXPECT_EQ(record["seed"], 7);
    EXPECT_EQ(record["ranges"], (Json{"1.f0=0.25", "m=0.1:1"}));
    EXPECT_EQ(record["warm_start"], false);
    EXPECT_EQ(record["driver"], test::device().driver);
    EXPECT_EQ(record["form"], to_json(test::device().form));
    EXPECT_EQ(record["kernels"], kernel_hash());
    EXPECT_TRUE(record["largest_albedo"].is_null() || record["largest_albedo"].contains("R"));
    // Another set of kernels is another record.
    const KernelFolder kernels("models/kurt.cl", "const float alpha", "const  float alpha");
    ASSERT_EQ(
        fit_paint(folder, {"-m", "kurt", "--force"}, {"BRDFIT_KERNELS=" + kernels.path().string()})
            .status,
        0);
    EXPECT_NE(written("paint.kurt.1.json").fit["kernels"], record["kernels"]);
}

TEST_F(Cli, a_parameter_at_its_bound_is_remarked_on_everywhere) {
    const std::vector<std::string> bound{"-m", "ward", "--bound", "m=0.4:0.5"};
    const Outcome table = fit(bound);
    ASSERT_EQ(table.status, 0) << table.err;
    EXPECT_NE(table.out.find("at bound: l1_m"), std::string::npos) << table.out;
    EXPECT_EQ(written("paint.ward.1.json").fit["remarks"][0], "at bound: l1_m");
    std::vector<std::string> options = bound;
    options.insert(options.end(), {"--csv", folder / "summary.csv"});
    EXPECT_EQ(fit_json(options).at(0)["remarks"][0], "at bound: l1_m");
    const CsvRow row = csv_rows(read_file(folder / "summary.csv")).at(0);
    EXPECT_EQ(row.at("remarks"), "at bound: l1_m");
    EXPECT_EQ(row.at("l1_m"), "0.4");
    EXPECT_EQ(row.at("l1_m_at_bound"), "1");
    const Outcome free = fit({"-m", "ward"});
    EXPECT_EQ(free.out.find("at bound"), std::string::npos) << free.out;
}

TEST_F(Cli, a_summary_has_a_column_for_each_parameter) {
    // A name that has to be quoted.
    const std::string file = folder / "pai\"nt, red.csv";
    std::filesystem::rename(folder / "paint.csv", file);
    const Outcome outcome =
        run_program({"fit", file, "-m", "ward,kurt", "--lobes", "1,2", "-o", folder / "out",
                     "--csv", folder / "summary.csv", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json fits = json::parse(outcome.out);
    const std::vector<CsvRow> rows = csv_rows(read_file(folder / "summary.csv"));
    ASSERT_EQ(rows.size(), 4U);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const CsvRow& row = rows[i];
        EXPECT_EQ(row.at("file"), file);
        EXPECT_EQ(row.at("material_file"), fits[i]["material_file"]);
        EXPECT_EQ(row.at("failed"), "");
        EXPECT_EQ(std::stod(row.at("error_ngan")), fits[i]["error"]["ngan"]);
        std::size_t filled = 0;
        for (const json& p : fits[i]["parameters"]) {
            // lobes[1].ks[R]: l2_ks_R
            std::string name = p["name"];
            for (const auto& [from, to] : {std::pair{"lobes[0].", "l1_"},
                                           {"lobes[1].", "l2_"},
                                           {"[R]", "_R"},
                                           {"[G]", "_G"},
                                           {"[B]", "_B"}})
                if (const std::size_t at = name.find(from); at != std::string::npos)
                    name.replace(at, std::string(from).size(), to);
            SCOPED_TRACE(name);
            ASSERT_TRUE(row.count(name));
            EXPECT_EQ(std::stod(row.at(name)), p["value"]);
            EXPECT_EQ(row.at(name + "_at_bound"), p["at_bound"] ? "1" : "0");
            if (p["standard_error"].is_null())
                EXPECT_EQ(row.at(name + "_se"), "");
            else
                EXPECT_EQ(std::stod(row.at(name + "_se")), p["standard_error"]);
            ++filled;
        }
        // The others belong to other rows.
        std::size_t at_bound = 0;
        for (const auto& [name, value] : row)
            at_bound +=
                name.size() > 9 && name.substr(name.size() - 9) == "_at_bound" && !value.empty();
        EXPECT_EQ(at_bound, filled);
    }
}

/// Fits of which only what the reports print is known.
FitRow row_with(double error) {
    FitRow row;
    row.result.model = "ward";
    row.result.errors.fill(error);
    row.result.material.channels = {"Y"};
    return row;
}

TEST(FitTable, aligns_errors_at_the_decimal_point) {
    const FitRow small = row_with(0.0000123), large = row_with(12.5), none = row_with(0);
    std::istringstream lines(fit_table({&large, &small, &none}, Metric::Ngan));
    std::string line;
    std::getline(lines, line);
    std::vector<std::size_t> points;
    while (std::getline(lines, line))
        points.push_back(line.find('.'));
    ASSERT_EQ(points.size(), 3U);
    EXPECT_EQ(points[0], points[1]);
    EXPECT_EQ(points[0], points[2]);
    const std::string text = fit_table({&large, &small, &none}, Metric::Ngan);
    EXPECT_NE(text.find(" 0.00001230 "), std::string::npos) << text;
    EXPECT_NE(text.find(" 12.50000000 "), std::string::npos) << text;
}

TEST(FitRemarks, say_what_makes_a_fit_doubtful) {
    FitResult result;
    EXPECT_TRUE(remarks_on(result).empty());
    const auto parameter = [&](const std::string& name, bool at_bound) {
        FittedParameter p{};
        p.name = name;
        p.at_bound = at_bound;
        result.parameters.push_back(p);
    };
    parameter("kd[R]", true); // no reflectance is no bound to mind
    parameter("lobes[0].m", false);
    EXPECT_TRUE(remarks_on(result).empty());
    parameter("lobes[1].alpha", true);
    parameter("lobes[1].f0", true);
    result.largest_albedo.value = 1.005; // within its tolerance
    EXPECT_EQ(remarks_on(result), Names{"at bound: l2_alpha, l2_f0"});
    result.largest_albedo.value = 1.25;
    result.largest_albedo.theta = 80;
    result.random_starts = 10;
    result.random_starts_better = 3;
    EXPECT_EQ(remarks_on(result), (Names{"at bound: l2_alpha, l2_f0", "R 1.25 at 80 degrees",
                                         "3 of 10 random starts better"}));
}

} // namespace

} // namespace brdfit

// brdfit fit as its users meet it: every option does what it says, and what is wrong ends with the
// right status, a message that says what, and no half-written file.

#include "host/files/channels.hpp"
#include "host/version.hpp"
#include "tests/support/cli.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <csignal>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace brdfit {

namespace {

using namespace test;
using nlohmann::json;

// fit: every option

TEST_F(Cli, fit_writes_a_material_for_each_model_and_number_of_lobes) {
    const json rows = fit_json({"-m", "ward,kurt-plausible+ward,lambert", "--lobes", "1,2"});
    EXPECT_EQ(out_names(), (Names{"paint.kurt-plausible+ward.2.json", "paint.lambert.0.json",
                                  "paint.ward.1.json", "paint.ward.2.json"}));
    ASSERT_EQ(rows.size(), 4U);
    for (const json& row : rows) {
        const Material material = read_material(row["material_file"]);
        EXPECT_EQ(material.lobes.size(), row["lobes"]);
        EXPECT_EQ(material.channels, (Names{"R", "G", "B"}));
        EXPECT_EQ(json::parse(material.fit["error"].dump()), row["error"]);
        EXPECT_EQ(row["file"], folder / "paint.csv");
        for (const json& p : row["parameters"])
            EXPECT_TRUE(material.fit["standard_error"].contains(p["name"])) << p;
    }
    EXPECT_EQ(written("paint.ward.2.json").lobes.size(), 2U);
    EXPECT_EQ(written("paint.lambert.0.json").lobes.size(), 0U);
}

TEST_F(Cli, fit_prints_a_table_sorted_by_error) {
    const Outcome outcome = fit({"-m", "lambert,kurt,ward"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto at = [&](const char* model) {
        return outcome.out.find(fmt::format("\n{} ", model));
    };
    EXPECT_LT(at("kurt"), at("ward"));
    EXPECT_LT(at("ward"), at("lambert"));
    EXPECT_LT(at("lambert"), std::string::npos);
    EXPECT_NE(outcome.out.find(folder / "paint.csv"), std::string::npos);
}

TEST_F(Cli, fit_records_where_the_material_comes_from) {
    ASSERT_EQ(fit({"-m", "ward", "--max-theta", "70", "--algorithm", "bobyqa"}).status, 0);
    const auto& record = written("paint.ward.1.json").fit;
    EXPECT_EQ(record["source"], folder / "paint.csv");
    EXPECT_EQ(record["sha256"].get<std::string>().size(), 64U);
    EXPECT_EQ(record["metric"], "ngan");
    EXPECT_EQ(record["max_theta"], 70);
    EXPECT_EQ(record["algorithm"], "LN_BOBYQA");
    EXPECT_EQ(record["version"], version);
    EXPECT_EQ(record["device"], test::device().name);
    EXPECT_GT(record["evaluations"], 0);
    EXPECT_GT(record["samples"], 0);
}

TEST_F(Cli, fit_all_takes_every_model) {
    const json rows = fit_json({"-m", "all"});
    std::set<std::string> models;
    for (const json& row : rows)
        models.insert(row["model"].get<std::string>());
    std::size_t listed = 0;
    for (const Model& model : catalogue()) {
        EXPECT_EQ(models.count(model.name), model.listed() ? 1U : 0U) << model.name;
        listed += model.listed() ? 1 : 0;
    }
    EXPECT_EQ(rows.size(), listed);
    EXPECT_EQ(out_names().size(), listed);
}

TEST_F(Cli, fit_names_what_is_asked_for_twice_once) {
    EXPECT_EQ(fit_json({"-m", "ward,ward", "--lobes", "1,1"}).size(), 1U);
    EXPECT_EQ(fit_json({"-m", "lambert", "--lobes", "1,2,3"}).size(), 1U);
}

TEST_F(Cli, fit_diffuse_chooses_the_diffuse_shape) {
    ASSERT_EQ(fit({"-m", "kurt", "--diffuse", "kurt-coupled"}).status, 0);
    EXPECT_EQ(out_names(), Names{"paint.kurt-coupled.1.json"});
    EXPECT_EQ(written("paint.kurt-coupled.1.json").diffuse->name, "kurt-coupled");
    expect_usage_error(fit({"-m", "kurt", "--diffuse", "ward"}), "ward");
    expect_usage_error(fit({"-m", "ward", "--diffuse", "kurt-coupled"}), "kurt-coupled");
    expect_usage_error(fit({"-m", "kurt-coupled", "--diffuse", "lambert"}), "kurt-coupled");
}

TEST_F(Cli, fit_metric_is_what_is_minimised) {
    std::map<std::string, json> errors;
    for (const char* metric : {"ngan", "l2", "log", "cbrt"}) {
        const json row = fit_json({"-m", "ward", "--metric", metric}).at(0);
        EXPECT_EQ(row["metric"], metric);
        errors[metric] = row["error"];
    }
    for (const auto& [metric, error] : errors)
        for (const auto& [other, unused] : errors)
            EXPECT_LE(error[metric].get<double>(), errors[other][metric].get<double>() * (1 + 1e-4))
                << metric << " when minimising " << other;
    expect_usage_error(fit({"-m", "ward", "--metric", "l1"}), "l1");
}

TEST_F(Cli, fit_max_theta_drops_samples) {
    const std::size_t all = fit_json({"-m", "ward", "--max-theta", "90"}).at(0)["samples"];
    const std::size_t most = fit_json({"-m", "ward"}).at(0)["samples"];
    const std::size_t few = fit_json({"-m", "ward", "--max-theta", "30"}).at(0)["samples"];
    EXPECT_EQ(all, 600U);
    EXPECT_LT(most, all);
    EXPECT_LT(few, most);
    EXPECT_GT(few, 0U);
    for (const char* angle : {"0", "91", "-5", "nan"})
        expect_usage_error(fit({"-m", "ward", "--max-theta", angle}), "--max-theta");
}

TEST_F(Cli, fit_starts_adds_random_starts) {
    const json without = fit_json({"-m", "ward"}).at(0);
    const json with = fit_json({"-m", "ward", "--starts", "5"}).at(0);
    EXPECT_FALSE(without.contains("random_starts_better"));
    EXPECT_EQ(with["random_starts_better"], 0);
    EXPECT_GT(with["evaluations"], without["evaluations"]);
    expect_usage_error(fit({"-m", "ward", "--starts", "-1"}), "--starts");
}

TEST_F(Cli, fit_start_replaces_the_search) {
    const json searched = fit_json({"-m", "kurt"}).at(0);
    const json started = fit_json({"-m", "kurt", "--start", folder / "paint.json"}).at(0);
    EXPECT_EQ(started["thinned_evaluations"], 0);
    EXPECT_GT(searched["thinned_evaluations"], 0);
    EXPECT_NEAR(started["error"]["ngan"].get<double>(), searched["error"]["ngan"].get<double>(),
                1e-4 * searched["error"]["ngan"].get<double>());
    expect_usage_error(fit({"-m", "ward", "--start", folder / "paint.json"}), "--start");
    expect_usage_error(fit({"-m", "kurt", "--start", folder / "paint.json", "--bound", "m=0.5:1"}),
                       "--start");
    expect_usage_error(fit({"-m", "ward", "--start", folder / "brushed.json"}), "--start");
    expect_input_error(fit({"-m", "kurt", "--start", folder / "missing.json"}), "missing.json");
}

TEST_F(Cli, fit_fix_and_bound_hold) {
    const auto theta = [&](const std::vector<std::string>& options, const std::string& file) {
        std::vector<std::string> arguments{"-m", "kurt"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = fit(arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return written(file).lobes.back().theta;
    };
    const std::string one = "paint.kurt.1.json", two = "paint.kurt.2.json";
    EXPECT_EQ(theta({"--fix", "f0=0.04"}, one)[0], 0.04);
    EXPECT_EQ(theta({"--fix", "f0=0.04", "--fix", "m=0.3"}, one)[1], 0.3);
    EXPECT_EQ(theta({"--lobes", "2", "--fix", "2.alpha=0"}, two)[2], 0);
    const double m = theta({"--bound", "m=0.3:0.5"}, one)[1];
    EXPECT_GE(m, 0.3);
    EXPECT_LE(m, 0.5);
    const Names at_bound = written(one).fit["at_bound"];
    EXPECT_EQ(std::count(at_bound.begin(), at_bound.end(), "lobes[0].m"), 1);
}

TEST_F(Cli, fit_fix_of_m_means_both_roughnesses_of_anisotropic_data) {
    synthesise("brushed", "brushed.csv");
    const Outcome outcome = run_program(
        {"fit", folder / "brushed.csv", "-m", "ward", "-o", folder / "out", "--fix", "m=0.25"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(written("brushed.ward.1.json").lobes[0].theta, (std::vector<double>{0.25, 0.25}));
}

TEST_F(Cli, fit_isotropy_is_what_the_data_says_unless_overridden) {
    synthesise("brushed", "brushed.csv");
    const auto fitted = [&](const std::string& file, const std::vector<std::string>& options) {
        std::vector<std::string> arguments{"fit", folder / file,  "-m",     "ward",
                                           "-o",  folder / "out", "--force"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return written(std::filesystem::path(file).stem().string() + ".ward.1.json").lobes[0];
    };
    EXPECT_TRUE(fitted("paint.csv", {}).isotropic);
    EXPECT_FALSE(fitted("paint.csv", {"--anisotropic"}).isotropic);
    EXPECT_TRUE(fitted("brushed.csv", {"--isotropic"}).isotropic);
    const Lobe brushed = fitted("brushed.csv", {});
    EXPECT_FALSE(brushed.isotropic);
    EXPECT_NEAR(brushed.theta[0], 0.2, 0.01);
    EXPECT_NEAR(brushed.theta[1], 0.4, 0.01);
    EXPECT_EQ(fit({"-m", "ward", "--isotropic", "--anisotropic"}).status, 2);
}

TEST_F(Cli, fit_algorithms_go_by_nlopt_s_names) {
    for (const char* name : {"slsqp", "LD_LBFGS", "bobyqa", "neldermead"})
        EXPECT_EQ(fit({"-m", "ward", "--algorithm", name}).status, 0) << name;
    expect_usage_error(fit({"-m", "ward", "--algorithm", "newton"}), "newton");
    expect_usage_error(fit({"-m", "ward", "--algorithm", "mlsl"}), "mlsl");
}

TEST_F(Cli, fit_max_evaluations_limits_a_polish) {
    const json few = fit_json({"-m", "kurt", "--max-evaluations", "2"}).at(0);
    const json many = fit_json({"-m", "kurt"}).at(0);
    EXPECT_LT(few["evaluations"], many["evaluations"]);
    expect_usage_error(fit({"-m", "kurt", "--max-evaluations", "0"}), "--max-evaluations");
}

TEST_F(Cli, fit_csv_summarises_every_fit) {
    const Outcome outcome =
        fit({"-m", "ward,kurt", "--lobes", "1,2", "--csv", folder / "summary.csv"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::istringstream lines(read_file(folder / "summary.csv"));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(
        line.rfind("file,model,lobes,metric,error_ngan,error_l2,error_log,error_cbrt,samples,", 0),
        0U)
        << line;
    const auto columns = std::count(line.begin(), line.end(), ',');
    std::set<std::string> fits;
    while (std::getline(lines, line)) {
        EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
        std::istringstream fields(line);
        std::string file, model, lobes;
        std::getline(fields, file, ',');
        std::getline(fields, model, ',');
        std::getline(fields, lobes, ',');
        EXPECT_EQ(file, folder / "paint.csv");
        fits.insert(model + lobes);
    }
    EXPECT_EQ(fits, (std::set<std::string>{"ward1", "ward2", "kurt1", "kurt2"}));
}

TEST_F(Cli, quiet_prints_results_and_errors_only_and_verbose_says_more) {
    const Outcome normal = fit({"-m", "ward"}), quiet = fit({"-m", "ward", "--quiet"}),
                  verbose = fit({"-m", "ward", "--verbose"});
    EXPECT_EQ(quiet.status, 0);
    EXPECT_EQ(quiet.err, "");
    EXPECT_EQ(normal.err, "");
    EXPECT_NE(quiet.out.find("ward"), std::string::npos);
    EXPECT_NE(verbose.err.find("search"), std::string::npos) << verbose.err;
    EXPECT_NE(
        run_program({"--quiet", "fit", folder / "missing", "-m", "ward", "-o", folder / "out"})
            .err.find("missing"),
        std::string::npos);
}

TEST_F(Cli, json_is_all_there_is_on_stdout) {
    const Outcome outcome = fit({"-m", "ward", "--json", "--verbose"});
    const json fits = json::parse(outcome.out);
    ASSERT_EQ(fits.size(), 1U) << outcome.out;
    EXPECT_EQ(fits[0]["model"], "ward");
}

TEST_F(Cli, equal_stems_get_distinct_names) {
    std::filesystem::create_directory(folder.path() / "other");
    std::filesystem::copy_file(folder / "paint.csv", folder / "other/paint.csv");
    std::filesystem::copy_file(folder / "paint.csv", folder / "paint-2.csv");
    const Outcome outcome =
        run_program({"fit", folder / "paint.csv", folder / "other/paint.csv",
                     folder / "paint-2.csv", "-m", "ward", "-o", folder / "out", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(out_names().size(), 3U);
    std::set<std::string> files;
    for (const json& row : json::parse(outcome.out)) {
        files.insert(row["material_file"].get<std::string>());
        EXPECT_EQ(read_material(row["material_file"]).fit["source"].dump(), row["file"].dump());
    }
    EXPECT_EQ(files.size(), 3U);
}

TEST_F(Cli, an_older_material_is_replaced) {
    std::filesystem::create_directory(folder.path() / "out");
    write_file(folder / "out/paint.ward.1.json", "old");
    ASSERT_EQ(fit({"-m", "ward"}).status, 0);
    EXPECT_NO_THROW(written("paint.ward.1.json"));
}

// fit: what is wrong

TEST_F(Cli, wrong_usage_of_fit_ends_with_2_before_anything_is_written) {
    const std::pair<std::vector<std::string>, const char*> cases[] = {
        {{"-m", "no-such"}, "no-such"},
        {{"-m", "ward,no-such"}, "no-such"},
        {{"-m", "ward+"}, "unknown model"},
        {{"-m", "ward+lambert"}, "lambert"},
        {{"-m", "ward+ward+ward+ward+ward"}, "lobes"},
        {{"-m", "ward", "--lobes", "0"}, "--lobes"},
        {{"-m", "ward", "--lobes", "5"}, "--lobes"},
        {{"-m", "ward", "--lobes", "two"}, "--lobes"},
        {{"-m", "ward", "--seed", "-1"}, "--seed"},
        {{"-m", "ward", "--seed", "0.5"}, "--seed"},
        {{"-m", "ward", "--diffuse", "no-such"}, "no-such"},
        {{"-m", "ward", "--device", "no such device"}, "no such device"},
        {{"-m", "ward", "--device", "99"}, "99"},
        {{"-m", "ward", "--fix", "m"}, "m"},
        {{"-m", "ward", "--fix", "=1"}, "=1"},
        {{"-m", "ward", "--fix", "m="}, "m="},
        {{"-m", "ward", "--fix", "m=x"}, "m=x"},
        {{"-m", "ward", "--fix", "m=nan"}, "nan"},
        {{"-m", "ward", "--fix", "m=11"}, "outside"},
        {{"-m", "ward", "--fix", "f0=0.5"}, "f0"},
        {{"-m", "kurt,ward", "--fix", "alpah=0"}, "'alpah'; they have alpha, "},
        {{"-m", "ward", "--fix", "9.m=0.5"}, "9.m"},
        {{"-m", "ward", "--bound", "m=0.5"}, "m=0.5"},
        {{"-m", "ward", "--bound", "m=1:0.5"}, "m=1:0.5"},
        {{"-m", "ward", "--bound", "m=0:0.5"}, "outside"},
        {{"-m", "ward", "--bound", "m=0.5:inf"}, "inf"},
        {{"-m", "ward", "--bound", "m=0.1:0.2", "--bound", "m=0.3:0.4"}, "nothing between"},
        {{"-m", "ward", "--bound", "m=0.1:0.2", "--fix", "m=0.5"}, "nothing between"},
        {{"-m", "ward", "--fix", "m=0.1", "--fix", "m=0.2"}, "nothing between"},
        {{"-m", "kurt", "--no-such-option"}, "--no-such-option"},
    };
    for (const auto& [options, says] : cases) {
        SCOPED_TRACE(fmt::format("{}", fmt::join(options, " ")));
        const Outcome outcome = fit(options);
        expect_usage_error(outcome, says);
        EXPECT_EQ(outcome.out, "");
        EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
    }
}

TEST_F(Cli, bounds_of_a_lobe_that_no_fit_has_are_wrong_usage) {
    expect_usage_error(fit({"-m", "ward", "--fix", "2.m=0.5"}), "2.m");
}

TEST_F(Cli, a_parameter_that_a_lobe_has_not_is_refused_with_those_it_has) {
    expect_usage_error(fit({"-m", "kurt+ward", "--fix", "1.alpah=0"}), "lobe 1 has alpha, ");
    expect_usage_error(fit({"-m", "kurt", "--fix", "3.alpha=0"}), "lobe 3 has none");
}

TEST_F(Cli, fit_refuses_a_seed_where_nothing_is_random) {
    expect_usage_error(fit({"-m", "lambert", "--seed", "3"}), "--seed");
    EXPECT_EQ(fit({"-m", "lambert", "--seed", "3", "--starts", "1"}).status, 0);
    EXPECT_EQ(fit({"-m", "lambert", "--seed", "3", "--algorithm", "crs2_lm"}).status, 0);
}

TEST_F(Cli, of_several_files_the_good_ones_are_fitted) {
    write_file(folder / "broken.csv", "theta_i,phi_i,theta_o,phi_o,R\n0.5,0,what,0,1\n");
    const Outcome outcome =
        run_program({"fit", folder / "broken.csv", folder / "missing.csv", folder / "paint.csv",
                     "-m", "ward", "-o", folder / "out", "--csv", folder / "summary.csv"});
    expect_input_error(outcome, "broken.csv");
    expect_input_error(outcome, "missing.csv");
    EXPECT_EQ(out_names(), Names{"paint.ward.1.json"});
    // The header, what failed with its reason, what was fitted.
    const std::string summary = read_file(folder / "summary.csv");
    EXPECT_EQ(std::count(summary.begin(), summary.end(), '\n'), 4);
    EXPECT_NE(summary.find("broken.csv: line 2"), std::string::npos) << summary;
}

TEST_F(Cli, data_without_a_usable_sample_is_bad_input) {
    write_file(folder / "grazing.csv", "theta_i,phi_i,theta_o,phi_o,R\n"
                                       "1.5,0,0.2,0,1\n0.2,0,1.5,1,1\n");
    const Outcome outcome =
        run_program({"fit", folder / "grazing.csv", "-m", "ward", "-o", folder / "out"});
    expect_input_error(outcome, "grazing.csv");
    EXPECT_NE(outcome.err.find("80"), std::string::npos) << outcome.err;
    EXPECT_EQ(out_names(), Names{});
    write_file(folder / "weightless.csv", "theta_i,phi_i,theta_o,phi_o,R,weight\n"
                                          "0.5,0,0.2,0,1,0\n0.2,0,0.5,1,1,0\n");
    expect_input_error(
        run_program({"fit", folder / "weightless.csv", "-m", "ward", "-o", folder / "out"}),
        "weightless.csv");
}

TEST_F(Cli, a_folder_that_cannot_be_written_ends_with_1) {
    expect_input_error(
        run_program({"fit", folder / "paint.csv", "-m", "ward", "-o", folder / "paint.csv/out"}),
        "paint.csv/out");
    expect_input_error(
        run_program({"fit", folder / "paint.csv", "-m", "ward", "-o", folder / "paint.csv"}),
        "paint.csv");
    expect_input_error(run_program({"fit", folder / "paint.csv", "-m", "ward", "-o", "/proc/out"}),
                       "/proc/out");
    expect_input_error(run_program({"demo", "-o", folder / "paint.csv/out"}), "paint.csv/out");
    std::filesystem::create_symlink("loop", folder / "loop");
    expect_input_error(
        run_program({"fit", folder / "paint.csv", "-m", "ward", "-o", folder / "loop"}),
        "loop: cannot make the folder");
}

TEST_F(Cli, a_file_s_name_need_not_be_utf_8) {
    const std::string name = folder / "paint\xff.csv";
    std::filesystem::copy(folder / "paint.csv", name);
    const Outcome outcome =
        run_program({"fit", name, "-m", "lambert", "-o", folder / "out", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json rows = json::parse(outcome.out);
    EXPECT_EQ(rows.at(0).at("file"), folder / "paint\xef\xbf\xbd.csv");
    const Material material = read_material(folder / "out/paint\xff.lambert.0.json");
    EXPECT_EQ(material.fit.at("source"), folder / "paint\xef\xbf\xbd.csv");
    EXPECT_EQ(run_program({"albedo", folder / "out/paint\xff.lambert.0.json", "--json", "-o",
                           folder / "a.csv"})
                  .status,
              0);
}

// Standard errors of so many strengths are in the material too.
TEST_F(Cli, as_many_channels_as_materials_have_are_fitted_and_read_back) {
    std::string text = "theta_i,phi_i,theta_o,phi_o";
    for (std::size_t ch = 0; ch < max_channels; ++ch)
        text += fmt::format(",c{}", ch);
    text += '\n';
    for (int row = 0; row < 20; ++row) {
        text += fmt::format("{},0,{},{}", 0.05 * row, 0.07 * (19 - row), 0.3 * row);
        for (std::size_t ch = 0; ch < max_channels; ++ch)
            text += fmt::format(
                ",{:.4f}", 0.1 + 0.01 * static_cast<double>(
                                            (ch * 7 + static_cast<std::size_t>(row) * 3) % 11));
        text += '\n';
    }
    write_file(folder / "many.csv", text);
    const Outcome outcome =
        run_program({"fit", folder / "many.csv", "-m", "kurt", "-o", folder / "out"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Material material = read_material(folder / "out/many.kurt.1.json");
    EXPECT_EQ(material.channels.size(), max_channels);
    EXPECT_GE(material.fit.at("standard_error").size(), 2 * max_channels);
}

TEST_F(Cli, a_full_disk_ends_with_1) {
    expect_input_error(fit({"-m", "ward", "--csv", "/dev/full"}), "/dev/full");
}

TEST_F(Cli, an_interrupted_fit_leaves_whole_materials_only) {
    std::filesystem::create_directory(folder.path() / "out");
    // Once the first material stands there, and well before the last.
    const Outcome outcome =
        interrupted({"fit", folder / "paint.csv", "-m", "all", "--lobes", "1,2,3", "--starts",
                     "1000", "-o", folder / "out"},
                    folder.path() / "out", [](const std::string& name) {
                        return std::filesystem::path(name).extension() == ".json";
                    });
    EXPECT_EQ(outcome.status, 128 + SIGINT) << outcome.err;
    EXPECT_FALSE(out_names().empty());
    for (const std::string& name : out_names())
        EXPECT_EQ(written(name).channels, (Names{"R", "G", "B"})) << name;
}

// Results do not depend on the machine's load.

TEST_F(Cli, materials_are_equal_to_the_bit_for_one_two_and_four_threads) {
    ASSERT_EQ(
        run_program({"synth", folder / "paint.json", folder / "paint.binary", "--noise", "0.02"})
            .status,
        0);
    std::vector<std::string> texts;
    for (const std::string threads : {"1", "2", "4"}) {
        const std::string out = folder / ("out" + threads);
        const Outcome outcome =
            run_program({"fit", folder / "paint.binary", folder / "paint.csv", "-m", "kurt,ward",
                         "--lobes", "1,2", "--starts", "2", "-o", out},
                        {"POCL_MAX_PTHREAD_COUNT=" + threads});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        std::string text;
        for (const std::string& name : names_in(out)) {
            std::istringstream lines(read_file(out + "/" + name));
            for (std::string line; std::getline(lines, line);)
                if (line.find("\"seconds\":") == std::string::npos)
                    text += line + "\n";
        }
        texts.push_back(text);
    }
    EXPECT_EQ(std::count(texts[0].begin(), texts[0].end(), '\n') > 100, true);
    EXPECT_EQ(texts[0], texts[1]);
    EXPECT_EQ(texts[0], texts[2]);
}

} // namespace

} // namespace brdfit

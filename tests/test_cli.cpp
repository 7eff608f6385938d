// The program as its users meet it: every option of devices, models, synth, fit, eval and demo does
// what it says, and what is wrong ends with the right status, a message that says what, and no
// half-written file.

#include "host/measured/read.hpp"
#include "host/model/evaluate.hpp"
#include "host/version.hpp"
#include "tests/fits.hpp"
#include "tests/reference_models.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

namespace brdfit {

namespace {

using nlohmann::json;
using test::Outcome;
using test::read_file;
using test::run_program;
using test::TemporaryFolder;
using test::write_file;

const std::string isotropic_material = R"({
  "brdfit": 1, "channels": ["R", "G", "B"],
  "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
  "lobes": [{"model": "kurt", "ks": [0.5, 0.4, 0.3], "f0": 0.5, "m": 0.2, "alpha": 0.1}]})";
const std::string anisotropic_material = R"({
  "brdfit": 1, "channels": ["R", "G", "B"],
  "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
  "lobes": [{"model": "ward", "ks": [0.5, 0.4, 0.3], "mx": 0.2, "my": 0.4}]})";

std::vector<std::string> names_in(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    if (std::filesystem::exists(folder))
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

using Names = std::vector<std::string>;

/// A folder with a material and a small measurement of it.
class Cli : public testing::Test {
  protected:
    Cli() {
        write_file(folder / "paint.json", isotropic_material);
        write_file(folder / "brushed.json", anisotropic_material);
        synthesise("paint", "paint.csv");
    }
    void synthesise(const std::string& material, const std::string& file, int count = 600) {
        const Outcome outcome =
            run_program({"synth", folder / (material + ".json"), folder / file, "--directions",
                         std::to_string(count), "--noise", "0.02"});
        if (outcome.status != 0)
            throw std::runtime_error(outcome.err);
    }
    /// Runs `fit` on the measurement, to the folder out.
    Outcome fit(const std::vector<std::string>& options) const {
        std::vector<std::string> arguments{"fit", folder / "paint.csv", "-o", folder / "out"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        return run_program(arguments);
    }
    json fit_json(std::vector<std::string> options) const {
        options.emplace_back("--json");
        const Outcome outcome = fit(options);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return json::parse(outcome.out);
    }
    Material written(const std::string& name) const {
        return read_material((folder.path() / "out" / name).string());
    }
    Names out_names() const { return names_in(folder.path() / "out"); }

    TemporaryFolder folder;
};

void expect_usage_error(const Outcome& outcome, const std::string& says) {
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(says), std::string::npos) << outcome.err;
}

void expect_input_error(const Outcome& outcome, const std::string& says) {
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_NE(outcome.err.find(says), std::string::npos) << outcome.err;
}

// What the program says of itself.

TEST(Program, version_goes_to_stdout) {
    const Outcome outcome = run_program({"--version"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.out, std::string(version) + "\n");
    EXPECT_EQ(outcome.err, "");
}

TEST(Program, help_of_every_command_has_an_example_of_that_command) {
    const Outcome help = run_program({"--help"});
    EXPECT_EQ(help.status, 0);
    std::istringstream lines(help.out.substr(help.out.find("Subcommands:")));
    std::string line;
    std::getline(lines, line);
    std::set<std::string> commands;
    while (std::getline(lines, line)) {
        std::istringstream words(line);
        std::string word;
        // Descriptions that go on are indented more deeply.
        if (line.size() > 2 && line[2] != ' ' && words >> word)
            commands.insert(word);
    }
    for (const char* known :
         {"devices", "models", "info", "synth", "convert", "fit", "eval", "demo"})
        EXPECT_EQ(commands.count(known), 1U) << known << " is not in:\n" << help.out;
    for (const std::string& command : commands) {
        const Outcome outcome = run_program({command, "--help"});
        EXPECT_EQ(outcome.status, 0) << command;
        EXPECT_NE(outcome.out.find("brdfit " + command), std::string::npos) << outcome.out;
        EXPECT_NE(outcome.out.find("Example"), std::string::npos) << outcome.out;
    }
}

TEST(Program, wrong_usage_ends_with_2_and_a_message) {
    for (const std::vector<std::string>& arguments :
         std::vector<std::vector<std::string>>{{},
                                               {"no-such-command"},
                                               {"fit"},
                                               {"fit", "file", "-m", "ward"},
                                               {"fit", "file", "-o", "out"},
                                               {"models", "--no-such-option"},
                                               {"models", "no-such-model"},
                                               {"devices", "surplus"},
                                               {"--quiet", "--verbose", "models"}}) {
        const Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.status, 2) << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_NE(outcome.err, "");
        EXPECT_EQ(outcome.out, "");
    }
}

TEST(Devices, are_listed_with_one_default) {
    const Outcome text = run_program({"devices"});
    EXPECT_EQ(text.status, 0);
    const json list = json::parse(run_program({"devices", "--json"}).out);
    ASSERT_FALSE(list.empty());
    int defaults = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
        EXPECT_EQ(list[i]["index"], i);
        EXPECT_NE(text.out.find(list[i]["name"].get<std::string>()), std::string::npos);
        EXPECT_GT(list[i]["compute_units"], 0);
        defaults += list[i]["default"].get<bool>() ? 1 : 0;
    }
    EXPECT_EQ(defaults, 1);
    EXPECT_EQ(std::count(text.out.begin(), text.out.end(), '*'), 1);
}

TEST(Models, are_listed_with_parameters_and_bounds) {
    const json list = json::parse(run_program({"models", "--json"}).out);
    std::vector<Model> listed;
    for (const Model& model : catalogue())
        if (model.listed())
            listed.push_back(model);
    ASSERT_EQ(list.size(), listed.size());
    const Outcome text = run_program({"models"});
    EXPECT_EQ(text.status, 0);
    for (std::size_t i = 0; i < list.size(); ++i) {
        const Model& model = listed[i];
        EXPECT_EQ(list[i]["name"], model.name);
        EXPECT_EQ(list[i]["equation"], model.equation);
        // A diffuse shape that goes with a lobe has that one's.
        const std::vector<Parameter>& parameters =
            model.lobe.empty() ? model.isotropic : model_named(model.lobe).isotropic;
        ASSERT_EQ(list[i]["isotropic"].size(), parameters.size());
        for (std::size_t p = 0; p < parameters.size(); ++p) {
            EXPECT_EQ(list[i]["isotropic"][p]["name"], parameters[p].name);
            EXPECT_EQ(list[i]["isotropic"][p]["lower"], parameters[p].lower);
            EXPECT_EQ(list[i]["isotropic"][p]["upper"], parameters[p].upper);
        }
        EXPECT_NE(text.out.find(model.equation), std::string::npos) << model.name;
        const json one = json::parse(run_program({"models", model.name, "--json"}).out);
        EXPECT_EQ(one, json::array({list[i]}));
    }
}

// synth

TEST_F(Cli, synth_repeats_with_one_seed_and_differs_with_another) {
    const auto synthesised = [&](const std::string& seed, const std::string& ending) {
        const std::string file = folder / ("seeded" + ending);
        const Outcome outcome = run_program({"synth", folder / "paint.json", file, "--directions",
                                             "500", "--noise", "0.1", "--seed", seed});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return read_file(file);
    };
    for (const std::string ending : {".csv", ".npy"}) {
        const std::string first = synthesised("5", ending);
        EXPECT_EQ(first, synthesised("5", ending));
        EXPECT_NE(first, synthesised("6", ending));
    }
}

TEST_F(Cli, synth_noise_has_the_standard_deviation_asked_for) {
    const Directions directions = *random_directions(4000, true, 3);
    std::string text = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n";
    for (std::size_t k = 0; k < directions.count(); ++k)
        text += fmt::format("{},{}\n", fmt::join(directions.wi(k), ","),
                            fmt::join(directions.wo(k), ","));
    write_file(folder / "directions.csv", text);
    for (const double s : {0.02, 0.3}) {
        ASSERT_EQ(run_program({"synth", folder / "paint.json", folder / "noisy.csv", "--directions",
                               folder / "directions.csv", "--noise", std::to_string(s)})
                      .status,
                  0);
        const Samples samples = read_samples(folder / "noisy.csv");
        ASSERT_EQ(samples.count(), directions.count());
        const Material material = read_material(folder / "paint.json");
        double sum = 0, squares = 0;
        for (std::size_t k = 0; k < samples.count(); ++k)
            for (std::size_t ch = 0; ch < 3; ++ch) {
                const double truth =
                    reference_evaluate(material, ch, directions.wi(k), directions.wo(k));
                const double n = samples.channel(ch)[k] / truth - 1;
                sum += n;
                squares += n * n;
            }
        const double count = 3.0 * static_cast<double>(samples.count());
        // Three times the scatter of mean and standard deviation of so many.
        EXPECT_NEAR(sum / count, 0, 3 * s / std::sqrt(count));
        EXPECT_NEAR(std::sqrt(squares / count), s, 3 * s / std::sqrt(2 * count));
    }
}

TEST_F(Cli, synth_without_noise_is_the_material) {
    ASSERT_EQ(run_program({"synth", folder / "paint.json", folder / "clean.binary"}).status, 0);
    const Samples samples = read_samples(folder / "clean.binary");
    const Material material = read_material(folder / "paint.json");
    std::size_t compared = 0;
    for (std::size_t k = 0; k < samples.count(); k += 1009)
        if (samples.valid[k] != 0) {
            const auto [wi, wo] = samples.directions->pair(k);
            const double truth = reference_evaluate(material, 1, wi, wo);
            EXPECT_NEAR(samples.channel(1)[k], truth, 1e-4 * truth);
            ++compared;
        }
    EXPECT_GT(compared, 500U);
}

TEST_F(Cli, synth_refuses_what_cannot_be_written) {
    expect_input_error(run_program({"synth", folder / "brushed.json", folder / "out.binary"}),
                       "anisotropic");
    expect_input_error(run_program({"synth", folder / "missing.json", folder / "out.binary"}),
                       "missing.json");
    expect_input_error(run_program({"synth", folder / "paint.csv", folder / "out.binary"}),
                       "paint.csv");
    expect_input_error(
        run_program({"synth", folder / "paint.json", folder / "no-such-folder/out.binary"}),
        "no-such-folder");
    expect_input_error(run_program({"synth", folder / "paint.json", folder / "out.csv",
                                    "--directions", folder / "missing.csv"}),
                       "missing.csv");
    expect_usage_error(run_program({"synth", folder / "paint.json", folder / "out.txt"}), ".txt");
    expect_usage_error(
        run_program({"synth", folder / "paint.json", folder / "out.binary", "--directions", "100"}),
        "--directions");
    expect_usage_error(
        run_program({"synth", folder / "paint.json", folder / "out.csv", "--directions", "0"}),
        "--directions");
    for (const char* noise : {"-1", "nan", "much"})
        expect_usage_error(run_program({"synth", folder / "paint.json", folder / "out.csv",
                                        "--noise", noise, "--directions", "10"}),
                           "--noise");
    EXPECT_EQ(names_in(folder.path()), (Names{"brushed.json", "paint.csv", "paint.json"}));
}

// eval

TEST_F(Cli, eval_gives_the_reference_s_values_as_csv_and_npy) {
    std::string text = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n";
    const Directions directions = *random_directions(50, false, 3);
    for (std::size_t k = 0; k < directions.count(); ++k)
        text += fmt::format("{},{}\n", fmt::join(directions.wi(k), ","),
                            fmt::join(directions.wo(k), ","));
    text += "0,0,1,0,0.6,-0.8\n"; // below the horizon
    write_file(folder / "directions.csv", text);
    for (const std::string material : {"paint", "brushed"}) {
        const Material truth = read_material(folder / (material + ".json"));
        const Outcome outcome =
            run_program({"eval", folder / (material + ".json"), folder / "directions.csv", "-o",
                         folder / "values.csv"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        std::istringstream lines(read_file(folder / "values.csv"));
        std::string line;
        std::size_t k = 0;
        bool header = false;
        while (std::getline(lines, line)) {
            if (line[0] == '#')
                continue;
            if (!header) {
                EXPECT_EQ(line, "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,R,G,B");
                header = true;
                continue;
            }
            std::vector<double> values;
            std::istringstream fields(line);
            for (std::string field; std::getline(fields, field, ',');)
                values.push_back(std::stod(field));
            ASSERT_EQ(values.size(), 9U);
            for (std::size_t ch = 0; ch < 3; ++ch) {
                const double expected =
                    k < directions.count()
                        ? reference_evaluate(truth, ch, directions.wi(k), directions.wo(k))
                        : 0;
                EXPECT_NEAR(values[6 + ch], expected, 1e-4 * expected) << line;
            }
            ++k;
        }
        EXPECT_EQ(k, directions.count() + 1);

        ASSERT_EQ(run_program({"eval", folder / (material + ".json"), folder / "directions.csv",
                               "-o", folder / "values.npy"})
                      .status,
                  0);
        const std::string bytes = read_file(folder / "values.npy");
        EXPECT_NE(bytes.find("(51, 9)"), std::string::npos);
        EXPECT_NE(bytes.find("'<f4'"), std::string::npos);
        float last[9];
        ASSERT_GT(bytes.size(), 51 * sizeof last);
        std::memcpy(last, bytes.data() + bytes.size() - 2 * sizeof last, sizeof last);
        const double expected = reference_evaluate(truth, 2, directions.wi(49), directions.wo(49));
        EXPECT_NEAR(last[8], expected, 1e-4 * expected);
    }
}

TEST_F(Cli, eval_refuses_broken_input_and_writes_nothing) {
    write_file(folder / "short.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,0.5\n");
    write_file(folder / "good.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    expect_input_error(
        run_program({"eval", folder / "paint.json", folder / "short.csv", "-o", folder / "v.csv"}),
        "short.csv");
    expect_input_error(
        run_program({"eval", folder / "good.csv", folder / "good.csv", "-o", folder / "v.csv"}),
        "good.csv");
    expect_usage_error(
        run_program({"eval", folder / "paint.json", folder / "good.csv", "-o", folder / "v.txt"}),
        ".txt");
    std::filesystem::create_symlink("/dev/full", folder / "full.csv");
    expect_input_error(run_program({"eval", folder / "paint.json", folder / "good.csv", "-o",
                                    folder / "full.csv"}),
                       "full.csv");
    for (const std::string& name : names_in(folder.path()))
        EXPECT_NE(name[0], 'v') << name;
}

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
        std::vector<std::string> arguments{"fit",  folder / file, "-m",
                                           "ward", "-o",          folder / "out"};
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
    EXPECT_NO_THROW(json::parse(outcome.out)) << outcome.out;
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

TEST_F(Cli, of_several_files_the_good_ones_are_fitted) {
    write_file(folder / "broken.csv", "theta_i,phi_i,theta_o,phi_o,R\n0.5,0,what,0,1\n");
    const Outcome outcome =
        run_program({"fit", folder / "broken.csv", folder / "missing.csv", folder / "paint.csv",
                     "-m", "ward", "-o", folder / "out", "--csv", folder / "summary.csv"});
    expect_input_error(outcome, "broken.csv");
    expect_input_error(outcome, "missing.csv");
    EXPECT_EQ(out_names(), Names{"paint.ward.1.json"});
    const std::string summary = read_file(folder / "summary.csv");
    EXPECT_EQ(std::count(summary.begin(), summary.end(), '\n'), 2);
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
}

TEST_F(Cli, a_full_disk_ends_with_1) {
    expect_input_error(fit({"-m", "ward", "--csv", "/dev/full"}), "/dev/full");
}

/// Runs the program and interrupts it as soon as a temporary file stands in the folder.
Outcome interrupted(const std::vector<std::string>& arguments,
                    const std::filesystem::path& folder) {
    return run_program(arguments, {}, [&](pid_t child) {
        for (int i = 0; i < 2000; ++i) {
            for (const std::string& name : names_in(folder))
                if (name.find(".part") != std::string::npos) {
                    kill(child, SIGINT);
                    return;
                }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        kill(child, SIGINT);
    });
}

TEST_F(Cli, an_interrupt_leaves_no_temporary_file) {
    const std::filesystem::path out = folder.path() / "interrupted";
    std::filesystem::create_directory(out);
    // So many rows take long enough to be met while they are written.
    const Outcome outcome = interrupted(
        {"synth", folder / "brushed.json", (out / "big.csv").string(), "--directions", "2000000"},
        out);
    EXPECT_EQ(outcome.status, 128 + SIGINT) << outcome.err;
    EXPECT_EQ(names_in(out), Names{});
}

TEST_F(Cli, an_interrupted_fit_leaves_whole_materials_only) {
    std::filesystem::create_directory(folder.path() / "out");
    const Outcome outcome =
        run_program({"fit", folder / "paint.csv", "-m", "all", "--lobes", "1,2,3", "--starts",
                     "1000", "-o", folder / "out"},
                    {}, [&](pid_t child) {
                        // Once the first material stands there, and well before the last.
                        for (int i = 0; i < 30000; ++i) {
                            bool any = false;
                            for (const std::string& name : out_names())
                                any = any || name.find(".json") == name.size() - 5;
                            if (any)
                                break;
                            std::this_thread::sleep_for(std::chrono::milliseconds(1));
                        }
                        kill(child, SIGINT);
                    });
    EXPECT_EQ(outcome.status, 128 + SIGINT) << outcome.err;
    EXPECT_FALSE(out_names().empty());
    for (const std::string& name : out_names())
        EXPECT_NO_THROW(written(name)) << name;
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

// demo

TEST(Demo, fits_every_model_to_three_materials_and_two_lobes_beat_one) {
    const TemporaryFolder folder;
    const Outcome outcome = run_program({"demo", "-o", folder / "demo"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::istringstream lines(read_file(folder / "demo/summary.csv"));
    std::string line;
    std::getline(lines, line);
    // file -> lobes -> best error
    std::map<std::string, std::map<std::string, double>> best;
    std::map<std::string, std::set<std::string>> fits;
    while (std::getline(lines, line)) {
        std::istringstream fields(line);
        std::string file, model, lobes, metric, error;
        for (std::string* field : {&file, &model, &lobes, &metric, &error})
            std::getline(fields, *field, ',');
        fits[file].insert(model + " " + lobes);
        const auto known = best[file].emplace(lobes, std::stod(error)).first;
        known->second = std::min(known->second, std::stod(error));
    }
    std::set<std::string> expected;
    for (const Model& model : catalogue())
        for (const char* lobes :
             model.listed() ? std::vector{"1", "2"} : std::vector<const char*>{})
            expected.insert(model.name + " " + (model.kind == Kind::Diffuse ? "0" : lobes));
    EXPECT_EQ(fits.size(), 3U);
    for (const auto& [file, names] : fits) {
        EXPECT_EQ(names, expected) << file;
        EXPECT_LT(best[file]["2"], 0.9 * best[file]["1"]) << file;
        EXPECT_LT(best[file]["1"], 0.9 * best[file]["0"]) << file;
        EXPECT_NE(outcome.out.find(file + ":"), std::string::npos);
    }
    EXPECT_EQ(names_in(folder.path() / "demo" / "fits").size(), 3 * expected.size());
    EXPECT_EQ(names_in(folder.path() / "demo" / "truth").size(), 3U);
    for (const std::string& name : names_in(folder.path() / "demo" / "fits"))
        EXPECT_NO_THROW(read_material(folder / ("demo/fits/" + name)));
}

} // namespace

} // namespace brdfit

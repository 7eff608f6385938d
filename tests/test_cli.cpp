// The program as its users meet it: every option of devices, models, synth, eval and demo does what
// it says, and what is wrong ends with the right status, a message that says what, and no
// half-written file.

#include "host/cli/command.hpp"
#include "host/device/cache.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/measured/read.hpp"
#include "host/version.hpp"
#include "tests/support/cli.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <spdlog/spdlog.h>
#include <sstream>

namespace brdfit {

namespace {

using namespace test;
using nlohmann::json;

// What the program says of itself.

TEST(Program, version_goes_to_stdout) {
    const Outcome outcome = run_program({"--version"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.out, std::string(version) + "\n");
    EXPECT_EQ(outcome.err, "");
}

// Nothing of one run is left for the next, nor for whoever called it.
TEST(Program, runs_twice_in_one_process) {
    const auto run = [](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "brdfit");
        std::vector<char*> argv;
        for (std::string& argument : arguments)
            argv.push_back(argument.data());
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        Outcome outcome;
        outcome.status = cli::run(static_cast<int>(argv.size()), argv.data());
        outcome.out = testing::internal::GetCapturedStdout();
        outcome.err = testing::internal::GetCapturedStderr();
        return outcome;
    };
    const auto logger = spdlog::default_logger();
    const auto level = spdlog::get_level();
    std::signal(SIGTERM, SIG_IGN);
    const TemporaryFolder folder;
    write_file(folder / "a.csv", "theta_i,phi_i,theta_o,phi_o,Y\n0.5,0,0.5,3,0.1\n");
    const Outcome quiet = run({"--quiet", "convert", folder / "a.csv", folder / "b.csv"});
    EXPECT_EQ(quiet.status, 0) << quiet.err;
    EXPECT_EQ(quiet.err, "");
    const Outcome loud = run({"convert", folder / "a.csv", folder / "b.csv"});
    EXPECT_EQ(loud.status, 0) << loud.err;
    EXPECT_EQ(loud.err, run_program({"convert", folder / "a.csv", folder / "b.csv"}).err);
    EXPECT_EQ(run({"info", folder / "a.csv"}).out, run_program({"info", folder / "a.csv"}).out);
    const Outcome missing = run({"info", folder / "missing"});
    EXPECT_EQ(missing.status, 1);
    EXPECT_NE(missing.err.find("brdfit: error: " + (folder / "missing")), std::string::npos)
        << missing.err;
    EXPECT_EQ(run({"no-such-command"}).status, 2);
    EXPECT_EQ(run({"models", "kurt"}).out, run_program({"models", "kurt"}).out);
    EXPECT_EQ(spdlog::default_logger(), logger);
    EXPECT_EQ(spdlog::get_level(), level);
    EXPECT_EQ(std::signal(SIGTERM, SIG_DFL), SIG_IGN);
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

TEST(Program, complaints_of_the_command_line_name_the_help_that_tells_more) {
    test::expect_usage_error(run_program({"fit", "a.csv", "-m", "kurt", "--lobes", "9"}),
                             "--lobes: Value 9 not in range 1 to 4; see brdfit fit --help\n");
    test::expect_usage_error(run_program({}), "; see brdfit --help\n");
}

TEST(Program, help_of_a_command_is_its_help) {
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{}, {"fit"}, {"eval"}}) {
        std::vector<std::string> help{"help"}, option = command;
        help.insert(help.end(), command.begin(), command.end());
        option.emplace_back("--help");
        const Outcome outcome = run_program(help);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.out, run_program(option).out);
    }
    expect_usage_error(run_program({"help", "no-such"}), "no-such");
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

TEST(Program, an_unknown_command_is_named_with_the_nearest_first) {
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"tabel"},
                                                      {"tabel", "--help"},
                                                      {"--device", "0", "tabel"},
                                                      {"help", "tabel"}}) {
        const Outcome outcome = run_program(arguments);
        expect_usage_error(outcome, "tabel: no such command; known: table, ");
        EXPECT_NE(outcome.err.find("fit"), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.out, "");
    }
    EXPECT_NE(run_program({"--help"}).out.find("brdfit help COMMAND"), std::string::npos);
}

TEST_F(Cli, a_device_is_refused_where_none_is_used) {
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"info", folder / "paint.csv"},
          {"convert", folder / "paint.csv", folder / "o.csv"},
          {"models"},
          {"albedo", folder / "paint.csv"}}) {
        std::vector<std::string> all{"--device", "0"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        expect_usage_error(run_program(all), "--device");
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "o.csv"));
}

TEST_F(Cli, a_file_of_another_kind_is_named) {
    const std::string material = folder / "paint.json", measured = folder / "paint.csv",
                      directions = folder / "d.csv", spec = folder / "g.json",
                      layout = folder / "t.json", merl = folder / "paint.binary";
    write_file(directions, "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    write_file(spec, R"({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.1})");
    write_file(layout, R"({"axes": []})");
    ASSERT_EQ(run_program({"synth", material, merl}).status, 0);
    ASSERT_EQ(run_program({"generate", spec, "-o", folder / "g.exr"}).status, 0);
    const std::string out = folder / "o.csv";
    const std::vector<std::pair<std::string, std::string>> kinds = {
        {measured, "is a measurement (scattered CSV)"},
        {merl, "is a measurement (MERL .binary)"},
        {material, "is a material"},
        {directions, "is a table of directions (CSV)"},
        {spec, "is a distribution's specification"},
        {layout, "is a table's specification"},
        {folder / "g.exr", "is a distribution's table (OpenEXR)"}};
    for (const auto& [file, says] : kinds) {
        const std::string what = file + " " + says + "; expected ";
        if (file != material) {
            if (file != measured && file != merl)
                expect_input_error(run_program({"eval", file, directions, "-o", out}),
                                   what + "a material file or a measurement");
            expect_input_error(run_program({"pdf", file, directions, "-o", out}), what);
            expect_input_error(run_program({"synth", file, out}), what);
            expect_input_error(run_program({"sample", file, "--wo", "3,0", "-n", "3", "-o", out}),
                               what);
            expect_input_error(fit({"-m", "kurt", "--start", file}), what);
        }
        if (file != directions) {
            expect_input_error(run_program({"eval", material, file, "-o", out}),
                               what + "directions");
            expect_input_error(
                run_program({"sample", material, "--wo", file, "-n", "3", "-o", out}), what);
            expect_input_error(run_program({"synth", material, out, "--directions", file}), what);
        }
        if (file != measured && file != merl) {
            expect_input_error(run_program({"info", file}), what + "a measurement");
            expect_input_error(run_program({"convert", file, out}), what);
        }
        if (file != spec)
            expect_input_error(run_program({"generate", file, "-o", folder / "o.exr"}), what);
        if (file != layout && file.find(".json") != std::string::npos)
            expect_input_error(run_program({"table", file, "-o", out}), what);
        if (file == directions || file == spec || file == layout || file == folder / "g.exr")
            expect_input_error(run_program({"albedo", file}),
                               what + "a material file or a measurement");
    }
    EXPECT_FALSE(std::filesystem::exists(out));
}

// The inputs are not there: whatever is said of them would come after.
TEST_F(Cli, endings_are_checked_before_the_inputs) {
    const std::string out = folder / "o.txt", none = folder / "none";
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"eval", none, none, "-o", out},
          {"pdf", none, none, "-o", out},
          {"sample", none, "--wo", "3,0", "-n", "3", "-o", out},
          {"convert", none, out},
          {"synth", none, out},
          {"albedo", none, "-o", out},
          {"fit", none, "-m", "kurt", "-o", folder / "fits", "--csv", out}})
        expect_usage_error(run_program(arguments), "o.txt: unknown ending; expected .");
}

TEST_F(Cli, a_seed_of_nothing_random_is_refused) {
    write_file(folder / "d.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    const std::string material = folder / "paint.json", out = folder / "o.csv";
    expect_usage_error(
        run_program({"synth", material, out, "--directions", folder / "d.csv", "--seed", "3"}),
        "--seed");
    expect_usage_error(run_program({"synth", material, folder / "o.binary", "--seed", "3"}),
                       "--seed");
    EXPECT_EQ(run_program({"synth", material, out, "--directions", folder / "d.csv", "--seed", "3",
                           "--noise", "0.1"})
                  .status,
              0);
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
    for (const auto* models : {&catalogue(), &table_models()})
        for (const Model& model : *models)
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
        EXPECT_NE(bytes.find("(51, 10)"), std::string::npos);
        EXPECT_NE(bytes.find("'<f4'"), std::string::npos);
        float last[10];
        ASSERT_GT(bytes.size(), 51 * sizeof last);
        std::memcpy(last, bytes.data() + bytes.size() - 2 * sizeof last, sizeof last);
        const double expected = reference_evaluate(truth, 2, directions.wi(49), directions.wo(49));
        EXPECT_NEAR(last[8], expected, 1e-4 * expected);
        EXPECT_EQ(last[9], 1);
    }
}

TEST_F(Cli, eval_s_npy_reads_back_as_samples) {
    write_file(folder / "some.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0.6,0.8\n");
    ASSERT_EQ(
        run_program({"eval", folder / "paint.json", folder / "some.csv", "-o", folder / "some.npy"})
            .status,
        0);
    const Samples samples = read_samples(folder / "some.npy");
    const Material truth = read_material(folder / "paint.json");
    ASSERT_EQ(samples.channels.size(), 3U);
    for (std::size_t ch = 0; ch < 3; ++ch) {
        const double expected = reference_evaluate(truth, ch, {0, 0, 1}, {0, 0.6, 0.8});
        EXPECT_NEAR(samples.channel(ch)[0], expected, 1e-4 * expected);
    }
    EXPECT_EQ(samples.weights, std::vector<float>{1});
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

TEST_F(Cli, an_interrupt_leaves_no_temporary_file) {
    const std::filesystem::path out = folder.path() / "interrupted";
    std::filesystem::create_directory(out);
    // So many rows take long enough to be met while they are written.
    const Outcome outcome = interrupted(
        {"synth", folder / "brushed.json", (out / "big.csv").string(), "--directions", "2000000"},
        out, [](const std::string& name) { return name.find(".part") != std::string::npos; });
    EXPECT_EQ(outcome.status, 128 + SIGINT) << outcome.err;
    EXPECT_EQ(names_in(out), Names{});
}

TEST_F(Cli, a_reader_that_leaves_and_a_crash_leave_no_temporary_file) {
    const std::filesystem::path out = folder.path() / "broken";
    std::filesystem::create_directory(out);
    const std::string remedy =
        is_pocl(device().platform) ? "POCL_CACHE_DIR" : "--device chooses another";
    for (const int signal : {SIGPIPE, SIGBUS, SIGSEGV, SIGABRT}) {
        const Outcome outcome = interrupted(
            {"synth", folder / "brushed.json", (out / "big.csv").string(), "--directions",
             "2000000"},
            out, [](const std::string& name) { return name.find(".part") != std::string::npos; },
            signal);
#ifndef __SANITIZE_ADDRESS__ // whose handlers stay
        EXPECT_EQ(outcome.status, 128 + signal) << outcome.err;
        EXPECT_EQ(names_in(out), Names{}) << signal;
        EXPECT_EQ(outcome.err.find(remedy) != std::string::npos, signal != SIGPIPE) << outcome.err;
#endif
    }
}

TEST(Program, an_output_that_takes_nothing_ends_with_1) {
    const std::string program = BRDFIT_PROGRAM;
    for (const std::string arguments :
         {"--help", "--version", "help fit", "fit --help", "models", "devices --json"}) {
        const Outcome outcome =
            run_command({"sh", "-c", program + " " + arguments + " >/dev/full"});
        EXPECT_EQ(outcome.status, 1) << arguments;
        EXPECT_NE(outcome.err.find("cannot write"), std::string::npos) << outcome.err;
    }
}

TEST_F(Cli, a_signal_that_was_ignored_stays_so) {
    // With no kernels in the cache: the driver's compiler has handlers of its own.
    const std::string cache = folder / "cache";
    std::filesystem::create_directory(cache);
    const Outcome outcome = run_command(
        {"sh", "-c",
         fmt::format("trap '' INT PIPE; POCL_CACHE_DIR={} {} synth {} {} --directions 300000 & "
                     "child=$!; while kill -INT $child && kill -PIPE $child; do sleep 0.02; done "
                     "2>{}; wait $child",
                     cache, BRDFIT_PROGRAM, folder / "brushed.json", folder / "whole.csv",
                     folder / "gone")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(std::filesystem::exists(folder / "whole.csv"));
}

TEST_F(Cli, a_file_that_is_replaced_is_said_once_it_is) {
    const std::vector<std::string> again{"convert", folder / "paint.csv", folder / "again.csv"};
    EXPECT_EQ(run_program(again).err, "");
    const Outcome second = run_program(again);
    EXPECT_EQ(second.status, 0);
    EXPECT_NE(second.err.find("again.csv was there and is replaced"), std::string::npos)
        << second.err;
    EXPECT_EQ(run_program({"-q", again[0], again[1], again[2]}).err, "");
    const Outcome failed = run_program({"convert", folder / "missing.csv", folder / "again.csv"});
    EXPECT_EQ(failed.err.find("replaced"), std::string::npos) << failed.err;
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
    const Outcome again = run_program({"demo", "-o", folder / "demo"});
    EXPECT_EQ(again.status, 1);
    EXPECT_NE(again.err.find("--force"), std::string::npos) << again.err;
    for (const std::string& name : names_in(folder.path() / "demo" / "fits"))
        EXPECT_NO_THROW(read_material(folder / ("demo/fits/" + name)));
}

} // namespace

} // namespace brdfit

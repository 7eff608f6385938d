// brdfit plan, run, status and merge as their users meet them: what is planned is made once,
// whatever the shards, and the results come back whole.

#include "fit/runs/merge.hpp"
#include "fit/runs/run.hpp"
#include "host/files/append.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/runs.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

namespace brdfit {

namespace {

using namespace test;
using nlohmann::json;

// plan

TEST_F(Runs, a_plan_lists_every_fit_once_with_an_output_of_its_own) {
    std::filesystem::create_directory(folder.path() / "other");
    std::filesystem::copy(folder / "b.csv", folder / "other/a.csv");
    plan({folder / "other/a.csv", "-m", "kurt,ward,lambert,kurt", "--lobes", "1,2", "--metric",
          "ngan,log,ngan"});
    const Plan planned = read_plan(folder / "run");
    EXPECT_EQ(planned.tasks.size(), 4U * 2 * 5);
    std::set<std::string> outputs, ids;
    for (const Task& task : planned.tasks) {
        outputs.insert(task.output);
        ids.insert(task.id);
        EXPECT_EQ(task.id.size(), 64U);
    }
    EXPECT_EQ(outputs.size(), planned.tasks.size());
    EXPECT_EQ(outputs.count("a-2.kurt.2.log.json"), 1U);
    // b.csv and other/a.csv are copies
    EXPECT_EQ(ids.size(), 3U * 2 * 5);
}

TEST_F(Runs, an_id_changes_with_all_that_determines_the_result_and_nothing_else) {
    const auto id = [&](const std::vector<std::string>& options) {
        std::vector<std::string> all{"-m", "kurt"};
        all.insert(all.end(), options.begin(), options.end());
        plan(all, "other");
        const std::string found = read_plan(folder / "other").tasks.front().id;
        std::filesystem::remove_all(folder.path() / "other");
        return found;
    };
    const std::string plain = id({});
    EXPECT_EQ(id({"--lobes", "1"}), plain);
    EXPECT_EQ(id({"--starts", "0", "--metric", "ngan,l2", "--algorithm", "LD_SLSQP"}), plain);
    std::set<std::string> ids{plain};
    for (const std::vector<std::string>& options :
         std::vector<std::vector<std::string>>{{"--metric", "l2"},
                                               {"--max-theta", "70"},
                                               {"--algorithm", "bobyqa"},
                                               {"--max-evaluations", "100"},
                                               {"--starts", "3"},
                                               {"--starts", "3", "--seed", "2"},
                                               {"--fix", "f0=0.5"},
                                               {"--bound", "f0=0.5:0.5"},
                                               {"--conserve"},
                                               {"--isotropic"},
                                               {"--anisotropic"},
                                               {"--orient"},
                                               {"--anisotropic", "--orient"},
                                               {"--diffuse", "kurt-coupled"},
                                               {"--lobes", "2"},
                                               {"--start", folder / "paint.json"}})
        EXPECT_TRUE(ids.insert(id(options)).second) << options.front();
}

TEST_F(Runs, a_plan_is_read_back_as_it_was_made) {
    plan({"-m", "kurt+ward,ggx", "--lobes", "1,2", "--fix", "2.m=0.1", "--bound", "f0=0.01:0.9",
          "--seed", "18446744073709551615", "--starts", "2", "--max-theta", "71.5", "--anisotropic",
          "--metric", "cbrt"});
    const Plan planned = read_plan(folder / "run");
    const FitOptions options = planned.options_of(planned.tasks.front());
    EXPECT_EQ(options.metric, Metric::Cbrt);
    EXPECT_EQ(options.seed, 18446744073709551615U);
    EXPECT_EQ(options.max_theta, 71.5);
    ASSERT_EQ(options.ranges.size(), 2U);
    EXPECT_EQ(text_of(options.ranges[0]), "2.m=0.1");
    EXPECT_EQ(text_of(options.ranges[1]), "f0=0.01:0.9");
    EXPECT_FALSE(options.start);
    EXPECT_EQ(planned.settings.isotropic, false);
    EXPECT_FALSE(planned.settings.orient);
    EXPECT_EQ(planned.tasks.size(), 3U * 3);
    plan({"-m", "kurt", "--orient", "--force"});
    EXPECT_TRUE(read_plan(folder / "run").settings.orient);
    plan({"-m", "kurt", "--start", folder / "paint.json", "--force"});
    const std::optional<Material> start = read_plan(folder / "run").settings.options.start;
    ASSERT_TRUE(start);
    EXPECT_EQ(start->lobes.front().theta, (std::vector<double>{0.5, 0.2, 0.1}));
}

TEST_F(Runs, plan_refuses_what_fit_refuses_and_what_is_there) {
    const auto refused = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"plan", "-o", folder / "run"});
        return run_program(arguments);
    };
    expect_usage_error(refused({folder / "a.csv", "-m", "nonsense"}), "nonsense");
    expect_usage_error(refused({folder / "a.csv", "-m", "kurt", "--metric", "ngan,l1"}), "l1");
    expect_usage_error(refused({folder / "a.csv", "-m", "kurt", "--fix", "g0=1"}), "g0");
    expect_usage_error(refused({folder / "a.csv", "-m", "kurt", "--seed", "2"}), "--seed");
    expect_usage_error(
        refused({folder / "a.csv", "-m", "kurt,ward", "--start", folder / "paint.json"}),
        "not those of ward");
    expect_usage_error(refused({folder / "a.csv", "-m", "kurt", "--shards", "2"}), "--slurm");
    expect_usage_error(refused({folder / "a.csv", "-m", "kurt", "--device", "0"}), "--device");
    expect_input_error(refused({folder / "missing.csv", "-m", "kurt"}), "missing.csv");
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "run"));
    plan();
    expect_input_error(refused({folder / "a.csv", "-m", "kurt"}), "--force");
}

TEST_F(Runs, a_plan_that_replaces_another_keeps_the_fits_that_both_have) {
    plan({"-m", "lambert,ward"});
    ASSERT_EQ(run().status, 0);
    plan({"-m", "lambert,kurt", "--force"});
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "run/shards/0-of-1.done"));
    const Outcome second = run({"--verbose"});
    EXPECT_EQ(second.status, 0);
    EXPECT_EQ(told_done(second).size(), 3U);
}

// shards

TEST_F(Runs, shards_share_a_plan_out_by_whole_files_where_they_can) {
    plan({"-m", "all", "--lobes", "1,2"});
    Plan planned = read_plan(folder / "run");
    const std::vector<Task> of_one(planned.tasks.begin(),
                                   planned.tasks.begin() +
                                       static_cast<std::ptrdiff_t>(planned.tasks.size() / 3));
    planned.tasks.clear();
    planned.files.clear();
    for (std::size_t f = 0; f < 100; ++f) {
        planned.files.push_back({"", fmt::format("{}", f), 1});
        for (Task task : of_one) {
            task.file = f;
            planned.tasks.push_back(task);
        }
    }
    for (const std::size_t count : {1U, 3U, 4U, 7U, 64U, 100U, 150U, 400U, 5000U}) {
        std::vector<std::size_t> all;
        double least = 1e9, most = 0;
        std::size_t parts = 0; // of files
        for (std::size_t i = 0; i < count; ++i) {
            const std::vector<std::size_t> tasks = tasks_of(planned, {i, count});
            double cost = 0;
            std::set<std::size_t> files;
            for (const std::size_t t : tasks) {
                cost += planned.tasks[t].cost();
                files.insert(planned.tasks[t].file);
            }
            least = std::min(least, cost);
            most = std::max(most, cost);
            parts += files.size();
            all.insert(all.end(), tasks.begin(), tasks.end());
        }
        std::sort(all.begin(), all.end());
        ASSERT_EQ(all.size(), planned.tasks.size()) << count;
        EXPECT_TRUE(std::adjacent_find(all.begin(), all.end()) == all.end()) << count;
        if (count <= 4 || count == 100) {
            EXPECT_EQ(parts, 100U) << count;
        }
        if (count <= 400) {
            EXPECT_LE(most, least * 1.5) << count;
        }
    }
}

TEST_F(Runs, shards_and_jobs_make_the_same_rows_as_one) {
    plan({"-m", "lambert,ward,kurt", "--lobes", "1,2", "--metric", "ngan,cbrt"});
    std::filesystem::copy(folder / "run", folder / "shards",
                          std::filesystem::copy_options::recursive);
    std::filesystem::copy(folder / "run", folder / "jobs",
                          std::filesystem::copy_options::recursive);
    ASSERT_EQ(run().status, 0);
    for (const char* shard : {"3/5", "0/5", "4/5", "1/5", "2/5"})
        ASSERT_EQ(run({"--shard", shard}, "shards").status, 0);
    ASSERT_EQ(run({"--jobs", "3"}, "jobs").status, 0);
    const std::vector<std::string> rows = merged();
    EXPECT_EQ(rows.size(),
              3U * 2 * 5 + query(folder / "run.sqlite", "SELECT 1 FROM parameters").size());
    EXPECT_EQ(merged("shards"), rows);
    EXPECT_EQ(merged("jobs"), rows);
}

// Whatever was fitted before in the same process, or was not.
TEST_F(Runs, a_result_does_not_depend_on_what_was_fitted_before) {
    write_file(folder / "bright.json", R"({"brdfit": 1, "channels": ["R"],
        "diffuse": {"model": "lambert", "kd": [0]},
        "lobes": [{"model": "kurt", "ks": [0.9], "f0": 1, "m": 0.3, "alpha": 0.6}]})");
    ASSERT_EQ(run_program({"synth", folder / "bright.json", folder / "bright.csv", "--directions",
                           "300", "--noise", "0.05"})
                  .status,
              0);
    for (const std::vector<std::string>& options :
         {std::vector<std::string>{"-m", "kurt+ward,ward,kurt", "--starts", "2"},
          {"-m", "kurt", "--conserve"},
          {"-m", "ward", "--metric", "log"},
          {"-m", "ward+kurt,ward", "--fix", "2.m=0.3"}}) {
        for (const char* name : {"whole", "parts"}) {
            std::vector<std::string> command{"plan", folder / "bright.csv", "--lobes", "1,2",
                                             "-o",   folder / name};
            command.insert(command.end(), options.begin(), options.end());
            ASSERT_EQ(run_program(command).status, 0);
        }
        const Plan planned = read_plan(folder / "whole");
        run_shard(planned, folder / "whole", fit_devices(), {});
        std::size_t made = 0;
        RunOptions one; // task at a time, with nothing known of the others
        one.fits_at_once = 1;
        one.finished = [&](const Task&, const std::string&) { ++made; };
        one.stop = [&] { return made > 0; };
        for (std::size_t i = 0; i < planned.tasks.size(); ++i, made = 0)
            EXPECT_EQ(run_shard(planned, folder / "parts", fit_devices(), one).left,
                      planned.tasks.size() - i - 1);
        EXPECT_EQ(merged("parts"), merged("whole")) << options[1];
        std::filesystem::remove_all(folder.path() / "whole");
        std::filesystem::remove_all(folder.path() / "parts");
    }
}

// run

TEST_F(Runs, what_is_done_is_not_made_again_by_any_shard) {
    plan();
    EXPECT_EQ(told_done(run({"--shard", "0/3", "--verbose"})).size(), 3U);
    EXPECT_EQ(told_done(run({"--verbose"})).size(), 6U);
    const Outcome again = run({"--verbose"});
    EXPECT_EQ(again.status, 0);
    EXPECT_EQ(told_done(again).size(), 0U);
    EXPECT_NE(again.out.find("9 done, 0 failed, 0 left"), std::string::npos) << again.out;
    EXPECT_EQ(read_file(folder / "run/shards/0-of-1.done"), "9 done, 0 failed\n");
}

TEST_F(Runs, run_refuses_shards_that_are_none) {
    plan();
    for (const char* shard : {"1/1", "-1/2", "0", "0/0", "a/2", "0/2x", "0/100001", ""})
        expect_usage_error(run({"--shard", shard}), "--shard");
    expect_usage_error(run({"--max-time", "0s"}), "--max-time");
    expect_usage_error(run({"--max-time", "5d"}), "--max-time");
    expect_usage_error(run({"--max-time", "nan"}), "--max-time");
    expect_usage_error(run({"--metric", "l2"}), "--metric");
    expect_input_error(run_program({"run", folder / "nowhere"}), "plan.json");
}

// Waits for a first row, then sends the signal.
std::function<void(pid_t)> signalled(const std::string& log, int signal) {
    return [log, signal](pid_t child) {
        std::error_code none;
        for (int i = 0; i < 30000 && !(std::filesystem::exists(log, none) &&
                                       std::filesystem::file_size(log, none) > 0);
             ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        kill(child, signal);
    };
}

TEST_F(Runs, signals_stop_after_the_current_task) {
    plan({"-m", "all", "--lobes", "2"});
    for (const int signal : {SIGTERM, SIGINT}) {
        std::filesystem::remove_all(folder.path() / "run/shards");
        // Kernels are compiled as it comes.
        const Outcome stopped =
            run_program({"run", folder / "run", "--verbose"},
                        {"POCL_CACHE_DIR=" + folder / fmt::format("kernels-{}", signal)},
                        signalled(log(), signal));
        EXPECT_EQ(stopped.status, 0) << stopped.err;
        EXPECT_NE(stopped.out.find(" left"), std::string::npos) << stopped.out;
        const ShardLog left = read_log(folder / "run", {});
        EXPECT_FALSE(left.torn);
        EXPECT_EQ(left.rows.size(), told_done(stopped).size()) << stopped.err;
        EXPECT_GE(left.rows.size(), 1U);
        EXPECT_LT(left.rows.size(), read_plan(folder / "run").tasks.size());
        EXPECT_FALSE(std::filesystem::exists(folder.path() / "run/shards/0-of-1.done"));
    }
}

TEST_F(Runs, signals_that_were_ignored_stay_so) {
    plan();
    const Outcome outcome = run_command(
        {"sh", "-c", "trap '' TERM; exec \"$0\" run \"$1\"", BRDFIT_PROGRAM, folder / "run"}, {},
        signalled(log(), SIGTERM));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.out.find("9 done, 0 failed, 0 left"), std::string::npos) << outcome.out;
}

TEST_F(Runs, no_task_begins_after_the_time_given) {
    plan();
    const Outcome none = run({"--max-time", "0.000001s"});
    EXPECT_EQ(none.status, 0);
    EXPECT_NE(none.out.find("0 done, 0 failed, 9 left"), std::string::npos) << none.out;
    EXPECT_NE(run({"--max-time", "1h"}).out.find("9 done"), std::string::npos);
}

TEST_F(Runs, two_processes_do_not_run_one_shard) {
    plan();
    std::filesystem::create_directory(folder.path() / "run/shards");
    {
        const AppendFile other(log());
        expect_input_error(run(), "another process");
        const json status = json::parse(run_program({"status", folder / "run", "--json"}).out);
        EXPECT_EQ(status["shards"][0]["running"], true);
    }
    EXPECT_EQ(run().status, 0);
}

// failures

TEST_F(Runs, a_failed_task_is_a_row_and_the_others_go_on) {
    const std::string whole = read_file(folder / "b.csv");
    write_file(folder / "b.csv", whole + "broken\n");
    plan();
    const Outcome first = run();
    EXPECT_EQ(first.status, 1);
    EXPECT_NE(first.out.find("6 done, 3 failed, 0 left"), std::string::npos) << first.out;
    merged();
    const std::vector<std::string> failed =
        query(folder / "run.sqlite", "SELECT path, model, failed FROM fits WHERE state = 'failed'");
    ASSERT_EQ(failed.size(), 3U);
    EXPECT_EQ(failed[0].rfind(folder / "b.csv|lambert|", 0), 0U) << failed[0];
    // What failed is not tried unasked.
    EXPECT_EQ(told_done(run({"--verbose"})).size(), 0U);
    EXPECT_NE(run({"--retry-failed"}).out.find("6 done, 3 failed"), std::string::npos);
}

TEST_F(Runs, a_file_that_changed_since_the_plan_fails_until_it_is_back) {
    plan();
    const std::string whole = read_file(folder / "b.csv");
    std::filesystem::copy_file(folder / "c.csv", folder / "b.csv",
                               std::filesystem::copy_options::overwrite_existing);
    const Outcome first = run();
    EXPECT_EQ(first.status, 1);
    EXPECT_NE(first.err.find("b.csv: has changed since the plan"), std::string::npos) << first.err;
    std::filesystem::remove(folder / "b.csv");
    EXPECT_NE(run({"--retry-failed"}).err.find("cannot open"), std::string::npos);
    write_file(folder / "b.csv", whole);
    const Outcome last = run({"--retry-failed", "--verbose"});
    EXPECT_EQ(last.status, 0);
    EXPECT_EQ(told_done(last).size(), 3U);
    merged();
    EXPECT_EQ(query(folder / "run.sqlite", "SELECT count(*) FROM fits WHERE state = 'done'"),
              Names{"9"});
}

// status

TEST_F(Runs, status_says_what_is_done_failed_and_left_by_shard) {
    write_file(folder / "c.csv", "broken");
    plan();
    run({"--shard", "0/3"});
    run({"--shard", "2/3"});
    const json status = json::parse(run_program({"status", folder / "run", "--json"}).out);
    EXPECT_EQ(status["tasks"], 9);
    EXPECT_EQ(status["done"], 3);
    EXPECT_EQ(status["failed"], 3);
    EXPECT_EQ(status["left"], 3);
    ASSERT_EQ(status["shards"].size(), 2U);
    EXPECT_EQ(status["shards"][0]["shard"], "0-of-3");
    EXPECT_EQ(status["shards"][0]["done"], 3);
    EXPECT_EQ(status["shards"][1]["failed"], 3);
    EXPECT_EQ(status["shards"][1]["running"], false);
    EXPECT_TRUE(status["seconds_left"].is_null());
    const Outcome people = run_program({"status", folder / "run"});
    EXPECT_NE(people.out.find("\n2-of-3              0       3      0"), std::string::npos)
        << people.out;
    run();
    const Outcome watched = run_program({"status", folder / "run", "--watch"});
    EXPECT_EQ(watched.status, 0);
}

// merge

TEST_F(Runs, materials_come_back_as_fit_writes_them) {
    const std::vector<std::string> what{"-m",  "ward,kurt,lambert", "--lobes",
                                        "1,2", "--starts",          "1"};
    plan(what);
    ASSERT_EQ(run().status, 0);
    std::vector<std::string> fit{"fit", folder / "a.csv", folder / "b.csv", folder / "c.csv",
                                 "-o",  folder / "fits",  "--csv",          folder / "fit.csv"};
    fit.insert(fit.end(), what.begin(), what.end());
    ASSERT_EQ(run_program(fit).status, 0);
    const std::vector<std::string> merge{"merge",           folder / "run", "--materials",
                                         folder / "merged", "--csv",        folder / "run.csv"};
    ASSERT_EQ(run_program(merge).status, 0);
    const Names names = names_in(folder.path() / "fits");
    EXPECT_EQ(names_in(folder.path() / "merged"), names);
    const auto timeless = [&](const std::string& path) {
        std::string text = read_file(path);
        const std::size_t begin = text.find("\"seconds\"");
        return text.erase(begin, text.find('\n', begin) - begin);
    };
    for (const std::string& name : names)
        EXPECT_EQ(timeless(folder / ("merged/" + name)), timeless(folder / ("fits/" + name)));
    const auto head = [&](const std::string& name) {
        const std::string text = read_file(folder / name);
        return text.substr(0, text.find(",material_file,"));
    };
    EXPECT_EQ(head("run.csv"), head("fit.csv"));
    expect_input_error(run_program(merge), "--force");
}

TEST_F(Runs, lobes_are_turned_where_the_plan_says_so) {
    write_file(folder / "brushed.json", R"({"brdfit": 1, "channels": ["R"],
        "diffuse": {"model": "lambert", "kd": [0.1]},
        "lobes": [{"model": "ward", "ks": [0.5], "mx": 0.4, "my": 0.15, "orientation": 30}]})");
    ASSERT_EQ(run_program({"synth", folder / "brushed.json", folder / "brushed.csv", "--directions",
                           "2000"})
                  .status,
              0);
    const auto lobe = [&](std::vector<std::string> options, const std::string& name) {
        options.insert(options.begin(),
                       {"plan", folder / "brushed.csv", "-m", "ward", "-o", folder / name});
        EXPECT_EQ(run_program(options).status, 0);
        EXPECT_EQ(run({}, name).status, 0);
        const std::string materials = folder / (name + "-materials");
        EXPECT_EQ(run_program({"merge", folder / name, "--materials", materials}).status, 0);
        return json::parse(read_file(materials + "/brushed.ward.1.json"))["lobes"][0];
    };
    EXPECT_FALSE(lobe({}, "straight").contains("orientation"));
    const json turned = lobe({"--orient"}, "turned");
    ASSERT_TRUE(turned.contains("orientation")) << turned.dump();
    EXPECT_NEAR(turned["orientation"].get<double>(), 30, 0.5);
}

TEST_F(Runs, the_best_materials_are_one_a_file) {
    plan({"-m", "ward,kurt,lambert"});
    ASSERT_EQ(run().status, 0);
    ASSERT_EQ(
        run_program({"merge", folder / "run", "--materials", folder / "best", "--best"}).status, 0);
    EXPECT_EQ(names_in(folder.path() / "best"),
              (Names{"a.kurt.1.json", "b.kurt.1.json", "c.kurt.1.json"}));
    expect_usage_error(run_program({"merge", folder / "run", "--csv", folder / "x.csv", "--best"}),
                       "--best");
    expect_usage_error(run_program({"merge", folder / "run"}), "-o");
    expect_usage_error(run_program({"merge", folder / "run", "-o", folder / "x.csv"}), ".sqlite");
}

TEST_F(Runs, parameters_are_tidy) {
    plan({"-m", "kurt", "--lobes", "2", "--fix", "alpha=0"});
    ASSERT_EQ(run().status, 0);
    merged();
    EXPECT_EQ(query(folder / "run.sqlite",
                    "SELECT lobe, parameter FROM parameters WHERE fit = 1 AND "
                    "parameter NOT LIKE 'k%' ORDER BY lobe, parameter"),
              (Names{"1|alpha", "1|f0", "1|m", "2|alpha", "2|f0", "2|m"}));
    EXPECT_EQ(query(folder / "run.sqlite",
                    "SELECT lobe, parameter FROM parameters WHERE fit = 1 AND parameter LIKE 'k%' "
                    "ORDER BY lobe, parameter"),
              (Names{"0|kd_G", "0|kd_R", "1|ks_G", "1|ks_R", "2|ks_G", "2|ks_R"}));
    EXPECT_EQ(query(folder / "run.sqlite",
                    "SELECT count(*) FROM fits JOIN parameters USING (fit) WHERE value = "
                    "json_extract(material, '$.lobes[0].m') AND lobe = 1 AND parameter = 'm'"),
              Names{"3"});
}

// Writes a log of one row, a changed copy of the first of another.
void write_changed_row(const std::string& folder, const std::string& shard,
                       const std::function<void(Json&)>& change) {
    const ShardLog log = read_log(folder, {});
    Json row = log.read(log.rows.front());
    change(row);
    write_file(folder + "/shards/" + shard + ".jsonl", sealed(row));
}

TEST_F(Runs, rows_that_contradict_each_other_are_an_error_that_names_both) {
    plan();
    ASSERT_EQ(run().status, 0);
    const std::vector<std::string> rows = merged();
    write_changed_row(folder / "run", "0-of-2", [](Json& row) {
        row["finished"] = 1;
        row["host"] = "elsewhere";
        row["material"]["fit"]["seconds"] = 7;
    });
    EXPECT_EQ(merged(), rows);
    write_changed_row(folder / "run", "0-of-2",
                      [](Json& row) { row["material"]["diffuse"]["kd"][0] = 0.123; });
    const Outcome conflict = run_program({"merge", folder / "run", "-o", folder / "run.sqlite"});
    expect_input_error(conflict, "0-of-1.jsonl:1");
    expect_input_error(conflict, "0-of-2.jsonl:1");
}

TEST_F(Runs, rows_of_unlike_devices_may_differ_a_little) {
    plan({"-m", "ward,kurt"});
    ASSERT_EQ(run().status, 0);
    plan({"-m", "ward,kurt"}, "other");
    ASSERT_EQ(run({}, "other", {"BRDFIT_FORM=4,1,512"}).status, 0);
    std::filesystem::copy_file(log("0-of-1", "other"), log("0-of-2"));
    const Outcome both = run_program({"merge", folder / "run", "-o", folder / "run.sqlite"});
    EXPECT_EQ(both.status, 0) << both.err;
    EXPECT_NE(both.err.find("vector_width 4"), std::string::npos) << both.err;
    EXPECT_NE(both.out.find("6 made twice"), std::string::npos) << both.out;
    write_changed_row(folder / "run", "0-of-3", [](Json& row) {
        row["material"]["fit"]["device"] = "another";
        row["material"]["fit"]["error"]["ngan"] =
            row["material"]["fit"]["error"]["ngan"].get<double>() * 1.0001;
    });
    expect_input_error(run_program({"merge", folder / "run", "-o", folder / "run.sqlite"}),
                       "0-of-3.jsonl:1");
}

TEST_F(Runs, an_unfinished_run_is_merged_as_far_as_it_is) {
    plan();
    ASSERT_EQ(run({"--shard", "1/3"}).status, 0);
    const Outcome outcome = run_program({"merge", folder / "run", "-o", folder / "run.sqlite"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.err.find("6 fits of the plan are not done"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(query(folder / "run.sqlite", "SELECT count(*) FROM fits"), Names{"3"});
    EXPECT_EQ(query(folder / "run.sqlite", "SELECT value FROM settings WHERE key = 'left'"),
              Names{"6"});
}

// Under a scheduler

// Stands in for Slurm: runs what is submitted at once, the elements of an array one by one.
constexpr const char* sbatch = R"(#!/bin/sh
echo "$*" >>"$0.log"
case "$*" in
*--dependency=afterany:7*) exec sh ;;
esac
for script; do :; done
last=$(sed -n 's/^#SBATCH --array=0-//p' "$script")
export SLURM_ARRAY_JOB_ID=7 SLURM_ARRAY_TASK_ID=0
while [ "$SLURM_ARRAY_TASK_ID" -le "$last" ]; do
    sh "$script" >&2 || exit 1
    SLURM_ARRAY_TASK_ID=$((SLURM_ARRAY_TASK_ID + 1))
done
echo '7;cluster'
)";

TEST_F(Runs, the_scripts_for_slurm_make_every_shard_and_merge) {
    const std::string run_folder = "it's a run"; // names need quotes
    plan({"-m", "lambert,ward", "--slurm", "--shards", "3"}, run_folder);
    const std::string bin = folder / "bin";
    std::filesystem::create_directory(bin);
    for (const auto& [name, text] :
         {std::pair{"sbatch", sbatch}, {"scontrol", "#!/bin/sh\nexit 1\n"}}) {
        write_file(bin + "/" + name, text);
        std::filesystem::permissions(bin + "/" + name, std::filesystem::perms::owner_all);
    }
    const Outcome outcome = run_command({"env", "PATH=" + bin + ":/usr/bin:/bin", "sh",
                                         folder / (run_folder + "/submit.sh"), "--partition=short"},
                                        {std::string("BRDFIT=") + BRDFIT_PROGRAM});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("6 done, 0 failed, 0 left"), std::string::npos) << outcome.out;
    EXPECT_EQ(query(folder / (run_folder + "/results.sqlite"), "SELECT count(*) FROM fits"),
              Names{"6"});
    EXPECT_EQ(names_in(folder.path() / run_folder / "shards").size(), 2U * 3);
    EXPECT_NE(read_file(bin + "/sbatch.log").find("--partition=short"), std::string::npos);
    plan({"-m", "lambert,ward", "--slurm"}, "small");
    EXPECT_NE(read_file(folder / "small/shards.sbatch").find("--array=0-0\n"), std::string::npos);
}

TEST_F(Runs, the_snakefile_plans_makes_every_shard_and_merges) {
    if (run_command({"sh", "-c", "command -v snakemake"}).status != 0)
        GTEST_SKIP() << "needs snakemake in PATH";
    write_file(folder / "c.csv", "broken");
    const Outcome outcome = run_command(
        {"snakemake", "-s", std::string(BRDFIT_SOURCES) + "/fit/runs/Snakefile", "--cores", "2",
         "--directory", folder.path().string(), "--config", "run=run", "shards=2", "threads=1",
         std::string("brdfit=") + BRDFIT_PROGRAM,
         fmt::format("files={} {} {}", folder / "a.csv", folder / "b.csv", folder / "c.csv"),
         "fit=-m lambert,ward"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(query(folder / "run/results.sqlite",
                    "SELECT state, count(*) FROM fits GROUP BY state ORDER BY state"),
              (Names{"done|4", "failed|2"}));
}

// A shard that is stopped before its end, as before a job's limit, puts itself back into the queue.
TEST_F(Runs, an_element_that_is_stopped_is_requeued) {
    plan({"-m", "all", "--lobes", "2", "--slurm", "--shards", "1"});
    write_file(folder / "scontrol", "#!/bin/sh\necho \"$*\"\n");
    std::filesystem::permissions(folder.path() / "scontrol", std::filesystem::perms::owner_all);
    const Outcome outcome =
        run_command({"env", "PATH=" + folder.path().string() + ":/usr/bin:/bin",
                     "SLURM_ARRAY_JOB_ID=9", "SLURM_ARRAY_TASK_ID=0",
                     std::string("BRDFIT=") + BRDFIT_PROGRAM, "sh", folder / "run/shards.sbatch"},
                    {}, signalled(log(), SIGTERM));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find(" left\nrequeue 9_0\n"), std::string::npos) << outcome.out;
}

} // namespace

} // namespace brdfit

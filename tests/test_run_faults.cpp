// What a run survives: kill -9 at any moment and at every write, logs that are cut or damaged, full
// disks and folders that cannot be written to, plans that are not what they were.

#include "fit/runs/run.hpp"
#include "host/files/append.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/runs.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <thread>

namespace brdfit {

namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr int killed = 128 + SIGKILL;

// Unlike write_file, in a new file: some file systems sync one that is cut to nothing and written.
void write_new_file(const std::string& path, const std::string& bytes) {
    fs::remove(path);
    write_file(path, bytes);
}

std::map<std::string, int> rows_by_id(const std::string& run) {
    std::map<std::string, int> counts;
    for (const ShardLog& log : read_logs(run).logs)
        for (const LoggedRow& row : log.rows)
            ++counts[row.id];
    return counts;
}

// How often the next test kills: 30 times, or as BRDFIT_KILLS says (kill_runs.sh).
int wished_kills() {
    const char* const wished = std::getenv("BRDFIT_KILLS");
    return wished != nullptr ? std::atoi(wished) : 30;
}

TEST_F(Runs, kills_at_random_moments_lose_and_repeat_nothing) {
    plan({"-m", "lambert,ward,ggx,kurt"}, "whole");
    ASSERT_EQ(run({"--max-time", "0.001s"}, "whole").status,
              0); // what the first start takes longer
    const auto started = std::chrono::steady_clock::now();
    ASSERT_EQ(run({}, "whole").status, 0);
    const std::chrono::duration<double> undisturbed = std::chrono::steady_clock::now() - started;
    const std::vector<std::string> rows = merged("whole");
    const std::size_t tasks = read_plan(folder / "whole").tasks.size();
    std::mt19937 random(20240229);
    std::uniform_real_distribution<double> share(0, 0.8);
    int kills = 0, rounds = 0;
    // A run is killed until it gets to its end; there are as many as it takes.
    for (; kills < wished_kills() && rounds < 100 * wished_kills(); ++rounds) {
        plan({"-m", "lambert,ward,ggx,kurt"});
        std::set<std::string> told;
        double patience = 1; // grows, lest a machine that is slower now never gets to the end
        for (bool ended = false; !ended; patience *= 1.1) {
            const auto moment = patience * share(random) * undisturbed;
            const Outcome outcome = run_program(
                {"run", folder / "run", "--verbose", "--jobs", std::to_string(1 + random() % 3)},
                {}, [&](pid_t child) {
                    std::this_thread::sleep_for(moment);
                    kill(child, SIGKILL);
                });
            ended = outcome.status == 0;
            ASSERT_TRUE(ended || outcome.status == killed) << outcome.err;
            kills += ended ? 0 : 1;
            for (const std::string& id : told_done(outcome))
                EXPECT_TRUE(told.insert(id).second) << id << " was done, and made again";
        }
        const std::map<std::string, int> made = rows_by_id(folder / "run");
        EXPECT_EQ(made.size(), tasks);
        for (const std::string& id : told)
            EXPECT_EQ(made.at(id), 1);
        // The folders' names are not part of them.
        EXPECT_EQ(merged(), rows);
        fs::remove_all(folder.path() / "run");
    }
    EXPECT_GE(kills, wished_kills());
    RecordProperty("kills", kills);
    fmt::print("{} kills, {} runs\n", kills, rounds);
}

TEST_F(Runs, kills_at_every_write_sync_and_rename_lose_and_repeat_nothing) {
    const std::vector<std::string> planning{"plan", folder / "a.csv", "-m", "lambert,ward",
                                            "-o",   folder / "run"};
    const auto at = [](int n) {
        return std::vector<std::string>{fmt::format("BRDFIT_KILL_AT={}", n)};
    };
    // Of the plan: there is none, or a whole one.
    int n = 1;
    for (;; ++n) {
        fs::remove_all(folder.path() / "run");
        const Outcome outcome = run_program(planning, at(n));
        if (outcome.status == 0)
            break;
        ASSERT_EQ(outcome.status, killed);
        if (fs::exists(folder.path() / "run/plan.json")) {
            EXPECT_EQ(read_plan(folder / "run").tasks.size(), 2U);
        } else {
            EXPECT_EQ(run_program(planning).status, 0);
        }
    }
    EXPECT_GE(n, 5); // write, flush, rename, folder
    ASSERT_EQ(run().status, 0);
    const std::vector<std::string> rows = merged();
    // Of the run.
    for (n = 1;; ++n) {
        fs::remove_all(folder.path() / "run/shards");
        const Outcome outcome = run({"--verbose"}, "run", at(n));
        if (outcome.status == 0)
            break;
        ASSERT_EQ(outcome.status, killed) << outcome.err;
        const std::vector<std::string> told = told_done(outcome);
        const Outcome again = run({"--verbose"});
        EXPECT_EQ(again.status, 0) << again.err;
        for (const std::string& id : told_done(again))
            EXPECT_EQ(std::count(told.begin(), told.end(), id), 0) << n;
        EXPECT_EQ(merged(), rows) << n;
        EXPECT_TRUE(fs::exists(folder.path() / "run/shards/0-of-1.done"));
    }
    EXPECT_GE(n, 11); // two folders, write and sync of two rows, the four of the .done file
    // Of the merge: there is none, or a whole one.
    for (n = 1;; ++n) {
        fs::remove(folder.path() / "run.sqlite");
        const Outcome outcome =
            run_program({"merge", folder / "run", "-o", folder / "run.sqlite"}, at(n));
        if (outcome.status == 0)
            break;
        ASSERT_EQ(outcome.status, killed) << outcome.err;
        if (fs::exists(folder.path() / "run.sqlite")) {
            EXPECT_EQ(query(folder / "run.sqlite", "SELECT count(*) FROM fits"), Names{"2"});
        }
    }
    EXPECT_GE(n, 4);
}

// Broken files fail fast: what a run does with its log is the same.
class BrokenRuns : public Runs {
  protected:
    BrokenRuns() {
        for (const char* name : {"a.csv", "b.csv", "c.csv"})
            write_file(folder / name, std::string("broken ") + name);
    }
};

TEST_F(BrokenRuns, a_log_cut_at_any_byte_of_its_last_two_lines_resumes) {
    plan({"-m", "lambert"});
    ASSERT_EQ(run().status, 1);
    const std::string whole = read_file(log());
    const Plan planned = read_plan(folder / "run");
    const std::vector<LoggedRow> rows = read_log(folder / "run", {}).rows;
    ASSERT_EQ(rows.size(), 3U);
    for (std::size_t bytes = rows[1].offset; bytes < whole.size(); ++bytes) {
        write_new_file(log(), whole.substr(0, bytes));
        const std::size_t kept = bytes < rows[2].offset ? 1 : 2;
        EXPECT_EQ(read_log(folder / "run", {}).rows.size(), kept) << bytes;
        std::size_t made = 0;
        RunOptions options;
        options.finished = [&](const Task&, const std::string&) { ++made; };
        EXPECT_EQ(run_shard(planned, folder / "run", fit_devices(), options).failed, 3U) << bytes;
        EXPECT_EQ(made, 3 - kept) << bytes;
        const ShardLog resumed = read_log(folder / "run", {});
        EXPECT_EQ(resumed.rows.size(), 3U) << bytes;
        EXPECT_FALSE(resumed.torn || !resumed.broken.empty()) << bytes;
    }
}

TEST_F(Runs, a_log_cut_within_a_done_line_resumes_to_the_same_rows) {
    plan();
    ASSERT_EQ(run().status, 0);
    const std::vector<std::string> rows = merged();
    const std::string whole = read_file(log());
    for (const std::size_t cut : {1U, 2U, 15U, 700U}) {
        write_file(log(), whole.substr(0, whole.size() - cut));
        EXPECT_EQ(told_done(run({"--verbose"})).size(), 1U);
        EXPECT_EQ(merged(), rows) << cut;
    }
}

TEST_F(Runs, any_flipped_bit_is_found_reported_and_not_merged) {
    plan({"-m", "lambert"});
    ASSERT_EQ(run().status, 0);
    const std::string whole = read_file(log());
    const std::size_t second = whole.find('\n') - 1; // with an end of line before and after it
    const std::size_t end = whole.find('\n', second + 2) + 2;
    for (std::size_t bit = 8 * second; bit < 8 * end; ++bit) {
        std::string flipped = whole;
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
        write_new_file(log(), flipped);
        const ShardLog read = read_log(folder / "run", {});
        EXPECT_TRUE(!read.broken.empty() || read.torn) << bit;
        EXPECT_LE(read.rows.size(), 2U) << bit;
        EXPECT_GE(read.rows.size(), 1U) << bit;
    }
    // The second line's: its task is made again.
    std::string flipped = whole;
    flipped[whole.find('\n') + 500] ^= 4;
    write_file(log(), flipped);
    const Outcome status = run_program({"status", folder / "run"});
    EXPECT_NE(status.out.find("0-of-1.jsonl:2: the checksum is wrong"), std::string::npos)
        << status.out;
    const Outcome merge = run_program({"merge", folder / "run", "-o", folder / "run.sqlite"});
    EXPECT_NE(merge.err.find("0-of-1.jsonl:2: the checksum is wrong"), std::string::npos)
        << merge.err;
    EXPECT_EQ(query(folder / "run.sqlite", "SELECT count(*) FROM fits"), Names{"2"});
    EXPECT_EQ(told_done(run({"--verbose"})).size(), 1U);
    merged();
    EXPECT_EQ(query(folder / "run.sqlite", "SELECT count(*) FROM fits"), Names{"3"});
}

TEST_F(Runs, whatever_stands_in_a_log_is_no_row_or_a_whole_one) {
    plan({"-m", "lambert"});
    ASSERT_EQ(run().status, 0);
    Mutations mutations(read_file(log()));
    for (int i = 0; i < 2000; ++i) {
        write_new_file(log(), mutations.next());
        EXPECT_NO_THROW(read_logs(folder / "run"));
    }
    // A line that never ends, and a checksum that is right of what is no row.
    write_file(log(), std::string(std::size_t{40} << 20, 'x') + "\n");
    EXPECT_EQ(read_log(folder / "run", {}).broken.size(), 1U);
    const std::string id = read_plan(folder / "run").tasks.front().id;
    write_file(log(), sealed({{"id", id}, {"state", "done"}, {"finished", 1.5}}));
    expect_input_error(run_program({"merge", folder / "run", "-o", folder / "run.sqlite"}),
                       "0-of-1.jsonl:1: is not a row of a run");
    EXPECT_FALSE(fs::exists(folder.path() / "run.sqlite"));
    write_file(log(), sealed({{"id", id}, {"state", "failed"}, {"finished", 1.5}}));
    expect_input_error(run_program({"merge", folder / "run", "-o", folder / "run.sqlite"}),
                       "0-of-1.jsonl:1: reason");
}

// A small file system in a folder, while the object lives; where that cannot be, `there` is false.
class SmallDisk {
  public:
    SmallDisk(std::string folder, const std::string& size) : folder_(std::move(folder)) {
        fs::create_directories(folder_);
        there =
            run_command({"mount", "-t", "tmpfs", "-o", "size=" + size, "tmpfs", folder_}).status ==
            0;
    }
    ~SmallDisk() {
        if (there)
            run_command({"umount", folder_});
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;
    void remount(const std::string& options) const {
        EXPECT_EQ(run_command({"mount", "-o", "remount," + options, folder_}).status, 0);
    }
    bool there = false;

  private:
    std::string folder_;
};

TEST_F(Runs, a_full_disk_stops_with_a_sentence_and_goes_on_later) {
    plan({"-m", "lambert,ward,kurt"}, "whole");
    ASSERT_EQ(run({}, "whole").status, 0);
    const SmallDisk disk(folder / "run", "16k");
    if (!disk.there)
        GTEST_SKIP() << "needs a small file system, which only root may mount";
    plan({"-m", "lambert,ward,kurt"});
    const Outcome full = run({"--verbose"});
    EXPECT_EQ(full.status, 1);
    EXPECT_NE(full.err.find("0-of-1.jsonl: cannot write: No space left on device"),
              std::string::npos)
        << full.err;
    const std::size_t told = told_done(full).size();
    EXPECT_GE(told, 1U);
    EXPECT_LT(told, 9U);
    disk.remount("size=10m");
    EXPECT_FALSE(read_log(folder / "run", {}).torn);
    EXPECT_EQ(told_done(run({"--verbose"})).size(), 9 - told);
    EXPECT_EQ(merged(), merged("whole"));
}

TEST_F(Runs, folders_that_cannot_be_written_to_are_named) {
    expect_input_error(run_program({"plan", folder / "a.csv", "-m", "ward", "-o", "/proc/run"}),
                       "/proc/run: cannot");
    plan();
    write_file(folder / "run/shards", "a file");
    expect_input_error(run(), "run/shards");
    fs::remove(folder.path() / "run/shards");
    expect_input_error(run_program({"merge", folder / "run", "-o", "/proc/x.sqlite"}),
                       "/proc/x.sqlite: cannot");
    const SmallDisk disk(folder / "fixed", "1m");
    if (!disk.there)
        GTEST_SKIP() << "needs a small file system, which only root may mount";
    plan({"-m", "lambert"}, "fixed");
    disk.remount("ro");
    expect_input_error(run({}, "fixed"), "Read-only file system");
}

TEST_F(Runs, plans_of_other_versions_and_edited_ones_are_refused) {
    plan();
    const std::string path = folder / "run/plan.json", whole = read_file(path);
    const auto refused = [&](const std::string& from, const std::string& to,
                             const std::string& says) {
        write_file(path, changed(whole, from, to));
        for (const char* command : {"run", "status"})
            expect_input_error(run_program({command, folder / "run"}), says);
    };
    refused("\"brdfit_plan\": 1", "\"brdfit_plan\": 2", "brdfit_plan: is 2; expected 1");
    refused("\"algorithm_version\": 1", "\"algorithm_version\": 0",
            "algorithm_version: is 0; expected 1");
    refused("\"max_theta\": 80", "\"max_theta\": 81", "is not as brdfit plan wrote it");
    refused("a.csv", "b.csv", "is not as brdfit plan wrote it");
    refused("\"kurt\"", "\"ward\"", "is not as brdfit plan wrote it");
    refused("{", "", "is no JSON");
    write_file(path, "");
    expect_input_error(run(), "empty");
    // Of the same meaning.
    write_file(path, changed(whole, "\n", " \n "));
    EXPECT_EQ(run().status, 0);
}

TEST_F(Runs, whatever_stands_in_a_plan_it_is_refused_or_the_same) {
    plan();
    const std::string path = folder / "run/plan.json", whole = read_file(path);
    const std::size_t tasks = read_plan(folder / "run").tasks.size();
    Mutations mutations(whole);
    for (int i = 0; i < 2000; ++i) {
        write_new_file(path, mutations.next());
        try {
            EXPECT_EQ(read_plan(folder / "run").tasks.size(), tasks);
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).rfind(path, 0), 0U) << error.what();
        }
    }
}

} // namespace

} // namespace brdfit

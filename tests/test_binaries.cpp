// Built programs kept between runs: what is kept, when it is used, and what becomes of bad files.

#include "host/device/binaries.hpp"
#include "host/device/buffer.hpp"
#include "host/device/cache.hpp"
#include "host/files/file.hpp"
#include "tests/support/support.hpp"

#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <thread>

namespace brdfit::test {

namespace {

namespace fs = std::filesystem;

constexpr const char* options = "-cl-std=CL1.2";
constexpr const char* doubling =
    "__kernel void twice(__global float* x) { x[get_global_id(0)] *= 2.0f; }";

/// A folder of its own for every test.
class Binaries : public testing::Test {
  protected:
    cl::Program built() const {
        cl::Program program(device().context, std::string(doubling));
        program.build(device().handle, options);
        return program;
    }
    std::optional<cl::Program> kept() const { return kept_program(device(), options, doubling); }
    void keep() const { keep_program(device(), options, doubling, built()); }
    std::vector<std::string> files() const {
        std::vector<std::string> paths;
        for (const auto& entry : fs::directory_iterator(binary_folder()))
            paths.push_back(entry.path().string());
        return paths;
    }

    // Opened before: it may be asked for its form by programs of its own.
    const Device& device_ = device();
    TemporaryFolder folder_;
    const std::string path_ = folder_ / "new/folder";
    const Variable variable_{"BRDFIT_CACHE", path_.c_str()};
};

float twice(const cl::Program& program, float x) {
    cl::Kernel kernel(program, "twice");
    const cl::Buffer buffer = upload(device(), std::vector<float>{x});
    kernel.setArg(0, buffer);
    device().queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
    return download<float>(device(), buffer, 1)[0];
}

} // namespace

TEST_F(Binaries, a_kept_program_runs_and_is_found_by_all_that_determines_it) {
    EXPECT_FALSE(kept());
    keep();
    ASSERT_TRUE(kept());
    EXPECT_EQ(twice(*kept(), 21), 42);
    EXPECT_FALSE(kept_program(device(), options, std::string(doubling) + " "));
    EXPECT_FALSE(kept_program(device(), "-cl-mad-enable", doubling));
    for (std::string Device::*const member :
         {&Device::platform, &Device::name, &Device::vendor, &Device::version, &Device::driver}) {
        Device other = device();
        other.*member += "x";
        EXPECT_FALSE(kept_program(other, options, doubling));
    }
    // Its parts are told apart: none can take a letter from the next.
    EXPECT_FALSE(kept_program(device(), "-cl-std=CL1.", std::string("2") + doubling));
}

TEST_F(Binaries, are_for_their_owner_alone) {
    keep();
    struct stat status {};
    ASSERT_EQ(stat(path_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0700U);
}

TEST_F(Binaries, a_damaged_foreign_or_empty_file_is_built_anew_and_replaced) {
    keep();
    ASSERT_EQ(files().size(), 1U);
    const std::string file = files()[0], whole = read_file(file);
    std::string flipped = whole;
    flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 1);
    for (const std::string& bytes :
         {std::string(), std::string("x"), whole.substr(0, 81), whole.substr(0, 82),
          whole.substr(0, whole.size() - 1), whole + "x", flipped,
          "brdfit program 2\n" + whole.substr(17)}) {
        write_file(file, bytes);
        EXPECT_FALSE(kept()) << bytes.size() << " of " << whole.size() << " bytes";
        keep();
        ASSERT_TRUE(kept());
        EXPECT_EQ(twice(*kept(), 3), 6);
    }
    EXPECT_EQ(files(), std::vector<std::string>{file});
    EXPECT_TRUE(take_replaced_files().empty()); // nothing that a user is told of
}

// Whole, but no program of this driver's.
TEST_F(Binaries, a_binary_that_the_driver_refuses_is_built_anew) {
    if (device().platform == "rusticl")
        GTEST_SKIP() << "rusticl ends the program at a binary that is not its own";
    keep();
    const std::string binary = "no program of any driver";
    write_file(files()[0], "brdfit program 1\n" + sha256(binary) + "\n" + binary);
    EXPECT_FALSE(kept());
}

TEST_F(Binaries, the_oldest_go_first) {
    keep();
    const std::string newest = files()[0];
    const auto now = fs::last_write_time(newest);
    for (int i = 0; i < 3; ++i) { // no bytes on the disk
        const std::string path = fmt::format("{}/{}.clbin", path_, i);
        write_file(path, "");
        fs::resize_file(path, most_binary_bytes / 2 - (1 << 20));
        fs::last_write_time(path, now - std::chrono::hours(10 - i));
    }
    write_file(path_ + "/notes.txt", "not ours");
    keep();
    EXPECT_FALSE(fs::exists(path_ + "/0.clbin"));
    for (const char* name : {"/1.clbin", "/2.clbin", "/notes.txt"})
        EXPECT_TRUE(fs::exists(path_ + name)) << name;
    EXPECT_TRUE(kept());
    EXPECT_LE(count_binaries().bytes, most_binary_bytes);
    EXPECT_EQ(clear_binaries().files, 3U);
    EXPECT_EQ(files(), std::vector<std::string>{path_ + "/notes.txt"});
}

TEST_F(Binaries, several_at_once_leave_one_whole_file) {
    const cl::Program program = built();
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 20; ++i)
                keep_program(device(), options, doubling, program);
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(files().size(), 1U);
    EXPECT_TRUE(kept());
}

// Errors that root meets too.
TEST_F(Binaries, a_place_that_cannot_be_written_is_no_error) {
    write_file(folder_ / "file", "");
    fs::create_symlink("loop", folder_ / "loop");
    for (const std::string& place : {folder_ / "file/x", folder_ / "file", folder_ / "loop",
                                     std::string(5000, 'x'), std::string()}) {
        const Variable cache("BRDFIT_CACHE", place.c_str());
        EXPECT_FALSE(kept());
        if (!place.empty())
            keep();
        EXPECT_EQ(count_binaries().files, 0U);
    }
}

TEST_F(Binaries, the_command_says_how_much_is_kept_and_removes_it) {
    const auto json = [](const std::vector<std::string>& arguments) {
        const Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out);
    };
    EXPECT_EQ(json({"cache", "--json"}).at("programs"), 0);
    keep();
    EXPECT_EQ(json({"cache", "--json"}).at("folder"), path_);
    EXPECT_EQ(json({"cache", "--json"}).at("programs"), 1);
    EXPECT_NE(run_program({"cache"}).out.find(path_ + ": 1 built programs"), std::string::npos);
    EXPECT_EQ(json({"cache", "--clear", "--json"}).at("removed"), 1);
    EXPECT_TRUE(files().empty());
    EXPECT_EQ(run_program({"--device", "0", "cache"}).status, 2);
    EXPECT_EQ(run_program({"cache"}, {"BRDFIT_CACHE="}).out,
              "no kernels are kept: no folder is named\n");
}

TEST(BinaryFolder, is_where_caches_belong) {
    const Variable cache("BRDFIT_CACHE", nullptr), home("HOME", "/home/someone"),
        none("XDG_CACHE_HOME", nullptr);
    EXPECT_EQ(binary_folder(), "/home/someone/.cache/brdfit");
    {
        const Variable caches("XDG_CACHE_HOME", "/caches");
        EXPECT_EQ(binary_folder(), "/caches/brdfit");
    }
    const Variable off("BRDFIT_CACHE", "");
    EXPECT_EQ(binary_folder(), "");
    EXPECT_FALSE(keeps_binaries(device()));
}

// A driver that keeps none itself: its second run builds nothing.
TEST_F(Binaries, commands_keep_what_the_driver_does_not) {
    write_file(folder_ / "m.json", R"({"brdfit": 1, "channels": ["R"], "lobes": [],
        "diffuse": {"model": "lambert", "kd": [0.1]}})");
    const Outcome outcome =
        run_program({"synth", folder_ / "m.json", folder_ / "v.csv", "--directions", "10"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(count_binaries().files > 0, !is_pocl(device().platform));
}

} // namespace brdfit::test

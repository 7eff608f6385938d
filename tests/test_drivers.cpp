// Drivers that crash, lie or run out of memory, and fits that several devices share.

#include "fit/fit_all.hpp"
#include "fit/runs/run.hpp"
#include "fit/structures.hpp"
#include "host/device/errors.hpp"
#include "host/device/probe.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/runs.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <thread>

namespace brdfit::test {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool is_pocl_alone() {
    return list_devices().size() == 1 && device().platform == "Portable Computing Language";
}

// PoCL shows its CPU twice.
constexpr const char* two_devices = "POCL_DEVICES=pthread pthread";

/// The small measurements of Runs, with drivers that tests/support/faulty_opencl.c makes bad.
class Drivers : public Runs {
  protected:
    void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
        GTEST_SKIP() << "AddressSanitizer wants to be loaded first";
#endif
        if (!is_pocl_alone())
            GTEST_SKIP() << "not the only device: PoCL's";
    }
    // Fits to a.csv with a driver that has these faults.
    Outcome fit(const std::vector<std::string>& faults,
                const std::vector<std::string>& options = {},
                const std::string& out = "out") const {
        std::vector<std::string> arguments{"fit", folder / "a.csv", "-m",     "ward,kurt,ggx",
                                           "-o",  folder / out,     "--force"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        return run_program(arguments, environment(faults));
    }
    std::vector<std::string> environment(std::vector<std::string> faults) const {
        faults.push_back(std::string("LD_PRELOAD=") + BRDFIT_FAULTY_OPENCL);
        faults.push_back("BRDFIT_CACHE=" + folder / "cache");
        return faults;
    }
    std::size_t materials() const {
        return names_in(folder.path() / "out").size();
    }
    // Programs kept; none is half-written.
    std::size_t kept() const {
        const Names names = names_in(folder.path() / "cache");
        for (const std::string& name : names)
            EXPECT_EQ(fs::path(name).extension(), ".clbin");
        return names.size();
    }
};

// Exit status and one message that has all parts.
void expect_failure(const Outcome& outcome, const std::vector<std::string>& parts) {
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    for (const std::string& part : parts)
        EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in " << outcome.err;
}

std::size_t warnings_in(const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find("warning: ", at)) != std::string::npos; ++at)
        ++count;
    return count;
}

} // namespace

// Bad drivers.

TEST_F(Drivers, one_that_crashes_while_it_compiles_is_named) {
    const Outcome outcome = fit({"FAULTY_BUILD=1"});
    EXPECT_EQ(outcome.status, 128 + SIGSEGV);
    for (const std::string& part : {std::string("crashed, perhaps in the driver last asked"),
                                    device().name, device().driver, device().platform})
        EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in " << outcome.err;
    EXPECT_EQ(materials(), 0U);
    // It is another's doing where there are several.
    const Outcome other =
        fit({"FAULTY_BUILD=1", two_devices, "FAULTY_DEVICE=0"}, {"--device", "1"});
    EXPECT_EQ(other.status, 0) << other.err;
}

TEST_F(Drivers, an_icd_file_that_names_nothing_is_as_none) {
    const std::string vendors = folder / "vendors";
    fs::create_directory(vendors);
    write_file(vendors + "/nothing.icd", "/nowhere/libnothing.so\n");
    write_file(vendors + "/empty.icd", "");
    expect_failure(fit({"OCL_ICD_VENDORS=" + vendors}), {"no OpenCL device found", "install"});
    fs::copy("/etc/OpenCL/vendors/pocl.icd", vendors + "/pocl.icd");
    EXPECT_EQ(fit({"OCL_ICD_VENDORS=" + vendors}).status, 0);
}

TEST_F(Drivers, without_binaries_nothing_is_kept) {
    const Outcome outcome = fit({"FAULTY_PLATFORM=Another", "FAULTY_BINARIES=1"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(warnings_in(outcome.err), 0U) << outcome.err;
    EXPECT_EQ(kept(), 0U);
}

TEST_F(Drivers, a_cache_that_cannot_be_written_is_one_warning) {
    write_file(folder / "cache", "a file");
    const Outcome outcome = fit({"FAULTY_PLATFORM=Another"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(warnings_in(outcome.err), 1U) << outcome.err;
    EXPECT_NE(outcome.err.find("BRDFIT_CACHE"), std::string::npos) << outcome.err;
    EXPECT_EQ(materials(), 3U);
}

TEST_F(Drivers, processes_that_fill_the_cache_at_once_leave_whole_programs) {
    std::vector<std::thread> others;
    for (int i = 0; i < 3; ++i)
        others.emplace_back([&, i] {
            EXPECT_EQ(fit({"FAULTY_PLATFORM=Another"}, {}, fmt::format("out{}", i)).status, 0);
        });
    for (std::thread& other : others)
        other.join();
    const std::size_t programs = kept();
    EXPECT_GT(programs, 3U);
    const Outcome last = fit({"FAULTY_PLATFORM=Another"}, {"--verbose"});
    EXPECT_EQ(last.status, 0);
    EXPECT_EQ(last.err.find("built anew"), std::string::npos) << last.err;
    EXPECT_EQ(kept(), programs);
}

TEST_F(Drivers, out_of_memory_half_way_fails_what_it_must_and_writes_nothing_broken) {
    for (const int buffers : {0, 3, 30, 50}) {
        fs::remove_all(folder.path() / "out");
        const Outcome outcome = fit({fmt::format("FAULTY_BUFFERS={}", buffers)});
        expect_failure(outcome, {"CL_MEM_OBJECT_ALLOCATION_FAILURE"});
        for (const std::string& name : names_in(folder.path() / "out"))
            EXPECT_NO_THROW(json::parse(read_file((folder.path() / "out" / name).string())));
    }
    fs::remove_all(folder.path() / "out");
    expect_failure(fit({"FAULTY_KERNELS=30"}), {"CL_OUT_OF_RESOURCES"});
}

TEST_F(Drivers, a_run_notes_what_a_device_without_memory_failed_at_and_makes_it_later) {
    plan();
    const Outcome outcome = run({}, "run", environment({"FAULTY_BUFFERS=60"}));
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(read_file(log()).find("CL_MEM_OBJECT_ALLOCATION_FAILURE"), std::string::npos);
    EXPECT_EQ(run({"--retry-failed"}).status, 0);
    plan({"-m", "lambert,ward,kurt"}, "whole");
    ASSERT_EQ(run({}, "whole").status, 0);
    EXPECT_EQ(merged(), merged("whole"));
}

// Of a driver's answers.

TEST_F(Drivers, whose_vectors_are_wrong_run_scalars) {
    const KernelFolder wrong("passes/answers.cl", "log(t)", "log(t) + (V > 1 ? 1e-3f : 0.0f)");
    const std::vector<std::string> faults{"FAULTY_PLATFORM=Another",
                                          "BRDFIT_KERNELS=" + wrong.path().string(),
                                          "BRDFIT_TUNING=" + folder / "tuning.json"};
    const Outcome outcome = fit(faults);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("wrong answers in vectors of 16: log at"), std::string::npos)
        << outcome.err;
    const json record = json::parse(read_file(folder / "out/a.kurt.1.json")).at("fit");
    EXPECT_EQ(record.at("form").at("vector_width"), 1);
    EXPECT_EQ(warnings_in(fit(faults).err), 0U); // remembered
}

TEST_F(Drivers, whose_answers_are_wrong_in_any_form_are_refused) {
    const KernelFolder wrong("passes/answers.cl", "sum += values[0]", "sum += values[1]");
    const std::vector<std::string> faults{"FAULTY_PLATFORM=Another",
                                          "BRDFIT_KERNELS=" + wrong.path().string(),
                                          "BRDFIT_TUNING=" + folder / "tuning.json"};
    expect_failure(fit(faults), {device().name, "wrong values: the sum over group 0"});
    EXPECT_EQ(materials(), 0U);
    const Outcome listed = run_program({"devices", "-v"}, environment(faults));
    EXPECT_NE(listed.out.find("WRONG VALUES"), std::string::npos) << listed.out;
    EXPECT_FALSE(fs::exists(folder / "tuning.json")); // asked again
}

TEST(Answers, of_this_driver_are_right_in_every_form) {
    Device asked = device();
    for (const bool vectors : {false, true}) {
        asked.vectors = vectors;
        asked.form = shipped_form(asked);
        EXPECT_EQ(wrong_answers(asked), "");
    }
    asked.form = {4, 16, 1024, 2};
    EXPECT_EQ(wrong_answers(asked), "");
}

// Several devices.

TEST_F(Drivers, a_list_names_several_devices_each_once) {
    const auto fits = [&](const std::string& wish) {
        return fit({two_devices}, {"--device", wish, "--verbose"});
    };
    for (const std::string wish : {"1,0,1", "all"}) {
        const Outcome outcome = fits(wish);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        for (const char* text : {"debug: device 0: ", "debug: device 1: "})
            EXPECT_EQ(outcome.err.find(text), outcome.err.rfind(text)) << outcome.err;
        EXPECT_NE(outcome.err.find("debug: device 1: "), std::string::npos) << outcome.err;
    }
    for (const std::string wish : {"0,", ",", "0,,1", "0,nothing", "portable", "0,2"})
        expect_usage_error(fits(wish), "--device");
    expect_usage_error(
        run_program({"--device", "0,1", "synth", folder / "paint.json", folder / "s.csv"},
                    {two_devices}),
        "matches no devices");
}

// Errors of all fits, by file and model.
std::vector<std::pair<std::string, double>> errors_in(const std::string& database) {
    std::vector<std::pair<std::string, double>> errors;
    for (const std::string& row :
         query(database, "SELECT path || ' ' || model, error_ngan FROM fits ORDER BY 1")) {
        const std::size_t end = row.rfind('|');
        errors.emplace_back(row.substr(0, end), std::stod(row.substr(end + 1)));
    }
    return errors;
}

TEST_F(Runs, fits_that_devices_share_are_those_of_one) {
    // Parts of the device where it has any, otherwise twice the whole: one as it comes, one that
    // adds in another order.
    const Variable units("BRDFIT_UNITS", has_sub_devices(device()) ? "1" : nullptr);
    const std::string index = std::to_string(device().index);
    Device other = open_device(index);
    other.name = "another";
    other.form.block /= 2;
    std::vector<std::string> many{"-m", "lambert,ward,ggx"};
    for (const char* name : {"d", "e", "f", "g"}) {
        many.push_back(folder / fmt::format("{}.csv", name));
        ASSERT_EQ(run_program({"synth", folder / "paint.json", many.back(), "--directions", "150",
                               "--noise", "0.02", "--seed", std::to_string(many.size())})
                      .status,
                  0);
    }
    RunOptions options;
    options.jobs = 2;
    // Three files, whose fits are shared; seven, which each device takes whole.
    for (const std::vector<std::string>& planned :
         {std::vector<std::string>{"-m", "lambert,ward,kurt,ggx"}, many}) {
        plan(planned, "one");
        run_shard(read_plan(folder / "one"), folder / "one", fit_devices(), {});
        merged("one");
        const auto one = errors_in(folder / "one.sqlite");
        std::string used;
        for (int i = 0; i < 10 && used != "2"; ++i) { // one may be done before the other begins
            FitDevices devices({open_device(index), other});
            plan(planned, "all");
            run_shard(read_plan(folder / "all"), folder / "all", devices, options);
            merged("all");
            const auto all = errors_in(folder / "all.sqlite");
            ASSERT_EQ(one.size(), all.size());
            for (std::size_t k = 0; k < one.size(); ++k) {
                EXPECT_EQ(one[k].first, all[k].first);
                EXPECT_NEAR(one[k].second, all[k].second, 1e-5 * one[k].second) << one[k].first;
            }
            used = query(folder / "all.sqlite", "SELECT count(DISTINCT device) FROM fits").at(0);
            fs::remove_all(folder.path() / "all");
            fs::remove(folder.path() / "all.sqlite");
        }
        EXPECT_EQ(used, "2");
        fs::remove_all(folder.path() / "one");
        fs::remove(folder.path() / "one.sqlite");
    }
}

TEST(FitDevices, take_what_pays_on_them) {
    FitDevices devices({device(), device()});
    const std::vector<bool> both{true, true};
    const auto lanes = static_cast<double>(devices[0].at_once);
    devices.took(0, 2, 2);
    devices.took(1, 2, 20); // ten times slower
    for (const double left : {1.0, 10.0, 1000.0})
        EXPECT_TRUE(devices.pays(0, 1, left, both, 0)) << left;
    EXPECT_FALSE(devices.pays(1, 1, 1, both, 0));
    EXPECT_FALSE(devices.pays(1, 1, 9.9 * lanes, both, 0));
    EXPECT_TRUE(devices.pays(1, 1, 10.1 * lanes, both, 0)); // the other would take longer
    EXPECT_TRUE(devices.pays(1, 1, 1, {false, true}, 0));   // there is no other
    // The whole of each works on a file.
    EXPECT_FALSE(devices.pays(1, 9, 89, both, 1));
    EXPECT_TRUE(devices.pays(1, 9, 91, both, 1));
}

TEST_F(Drivers, a_device_without_memory_leaves_its_fits_to_the_others) {
    for (const int buffers : {0, 5, 20}) {
        const Outcome outcome =
            fit({two_devices, "FAULTY_DEVICE=0", fmt::format("FAULTY_BUFFERS={}", buffers)},
                {"--device", "all"});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(materials(), 3U);
        if (buffers == 0) { // what comes later may all be the other's
            EXPECT_NE(outcome.err.find("device 0 (pthread"), std::string::npos) << outcome.err;
        }
    }
}

} // namespace brdfit::test

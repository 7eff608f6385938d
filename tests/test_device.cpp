// Choosing a device, and what the program says where there is none or where kernels do not build.

#include "host/device/device.hpp"
#include "host/device/errors.hpp"
#include "host/error.hpp"
#include "host/model/structure.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/support.hpp"

#include <CL/opencl.hpp>
#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <new>
#include <nlohmann/json.hpp>

namespace brdfit {

namespace {

using test::KernelFolder;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;
using test::write_file;

const std::string material = R"({
  "brdfit": 1, "channels": ["R"],
  "diffuse": {"model": "lambert", "kd": [0.1]},
  "lobes": [{"model": "ward", "ks": [0.5], "m": 0.2}]})";

std::string upper_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

TEST(OpenDevice, chooses_by_index_name_part_of_the_name_or_default) {
    const std::vector<Device> devices = list_devices();
    ASSERT_FALSE(devices.empty());
    EXPECT_EQ(open_device().index, static_cast<int>(default_device(devices)));
    for (const Device& device : devices) {
        EXPECT_EQ(open_device(std::to_string(device.index)).index, device.index);
        const auto alike = [&](const std::string& wish) {
            return std::count_if(devices.begin(), devices.end(), [&](const Device& d) {
                for (const std::string& of : {d.name, d.platform, d.vendor})
                    if (upper_case(of).find(upper_case(wish)) != std::string::npos)
                        return true;
                return false;
            });
        };
        for (const std::string& wish : {device.name, upper_case(device.name), device.name.substr(1),
                                        device.platform, upper_case(device.vendor)})
            if (alike(wish) == 1) {
                EXPECT_EQ(open_device(wish).index, device.index) << wish;
            } else {
                EXPECT_THROW(open_device(wish), UsageError) << wish;
            }
    }
}

TEST(OpenDevice, matches_parts_of_name_platform_and_vendor) {
    std::vector<Device> devices(3);
    devices[0].name = "Xeon";
    devices[0].platform = "Intel(R) OpenCL";
    devices[1].name = "pthread-Intel(R) Xeon";
    devices[1].platform = "Portable Computing Language";
    devices[2].name = "llvmpipe";
    devices[2].vendor = "Mesa/X.org";
    using Matches = std::vector<std::size_t>;
    for (const auto& [wish, matches] :
         std::vector<std::pair<std::string, Matches>>{{"0", {0}},
                                                      {"2", {2}},
                                                      {"3", {}},
                                                      {"intel", {0, 1}},
                                                      {"INTEL(R) OPENCL", {0}},
                                                      {"portable", {1}},
                                                      {"mesa", {2}},
                                                      {"nvidia", {}}})
        EXPECT_EQ(matching_devices(devices, wish), matches) << wish;
}

TEST(OpenDevice, names_the_devices_where_none_matches) {
    for (const std::string wish : {"no such device", "99", "-1", "0x", " "}) {
        // A blank may well be a part of one's name.
        if (wish == " " && list_devices()[0].name.find(' ') != std::string::npos)
            continue;
        try {
            open_device(wish);
            ADD_FAILURE() << "accepted '" << wish << "'";
        } catch (const UsageError& error) {
            EXPECT_NE(std::string(error.what()).find(list_devices()[0].name), std::string::npos)
                << error.what();
        }
    }
}

TEST(Forms, are_what_the_kernels_expect) {
    const auto power_of_2 = [](int n) { return n > 0 && (n & (n - 1)) == 0; };
    for (const Device& device : list_devices()) {
        EXPECT_TRUE(power_of_2(device.form.vector_width) && device.form.vector_width <= 16);
        EXPECT_TRUE(power_of_2(device.form.local_size));
        EXPECT_LE(static_cast<std::size_t>(device.form.local_size), device.max_group);
        EXPECT_EQ(device.form.block % (device.form.vector_width * device.form.local_size), 0);
    }
}

class Program : public testing::Test {
  protected:
    Program() {
        write_file(folder / "m.json", material);
        write_file(folder / "d.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    }
    Outcome eval(const std::vector<std::string>& options,
                 const std::vector<std::string>& environment = {}) const {
        std::vector<std::string> arguments{"eval", folder / "m.json", folder / "d.csv", "-o",
                                           folder / "v.csv"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        return run_program(arguments, environment);
    }
    TemporaryFolder folder;
};

TEST_F(Program, takes_the_device_by_index_and_by_a_part_of_its_name) {
    const Device& device = test::device();
    EXPECT_EQ(eval({"--device", std::to_string(device.index)}).status, 0);
    const Outcome listed =
        run_program({"--device", std::to_string(device.index), "devices", "--json"});
    EXPECT_EQ(listed.status, 0);
    const auto list = nlohmann::json::parse(listed.out);
    ASSERT_EQ(list.size(), 1U);
    EXPECT_EQ(list[0]["name"], device.name);
    const bool only_one = list_devices().size() == 1;
    EXPECT_EQ(eval({"--device", upper_case(device.name.substr(0, 5))}).status, only_one ? 0 : 2);
}

TEST_F(Program, says_of_each_device_what_was_chosen_and_why) {
    const Outcome outcome = run_program({"devices", "-v"});
    EXPECT_EQ(outcome.status, 0);
    for (const char* text : {"form: ", "built kernels: kept by ", "fewer threads: "})
        EXPECT_NE(outcome.out.find(text), std::string::npos) << text << outcome.out;
    EXPECT_EQ(run_program({"devices"}).out.find("form: "), std::string::npos);
    const auto listed = nlohmann::json::parse(
        run_program({"devices", "-v", "--json"}, {"BRDFIT_FORM=1,1,1024"}).out);
    for (const auto& device : listed) {
        EXPECT_EQ(device.at("form").at("block"), 1024);
        EXPECT_EQ(device.at("form_reason"), "BRDFIT_FORM asks for it");
    }
}

TEST_F(Program, uses_as_many_compute_units_as_asked_for) {
    const Device& device = test::device();
    if (!has_sub_devices(device))
        GTEST_SKIP() << device.name << " cannot be split into sub-devices";
    {
        const test::Variable one("BRDFIT_UNITS", "1");
        const Device part = open_device(std::to_string(device.index));
        EXPECT_EQ(part.compute_units, 1U);
        EXPECT_EQ(part.handle.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>(), 1U);
        EXPECT_EQ(part.name, device.name);
    }
    const std::string more = std::to_string(device.compute_units + 1);
    for (const std::string units : {"0", "-1", "x", "1x", "1.5", more.c_str()}) {
        const Outcome outcome = eval({}, {"BRDFIT_UNITS=" + units});
        EXPECT_EQ(outcome.status, 2) << units;
        EXPECT_NE(outcome.err.find("BRDFIT_UNITS=" + units), std::string::npos) << outcome.err;
    }
    const Outcome all = eval({}), one = eval({}, {"BRDFIT_UNITS=1"});
    EXPECT_EQ(all.status, 0);
    EXPECT_EQ(one.status, 0) << one.err;
    EXPECT_EQ(eval({}, {"BRDFIT_UNITS="}).status, 0);
}

TEST_F(Program, ends_with_2_where_no_device_matches) {
    const Outcome outcome = eval({"--device", "no such device"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find(test::device().name), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "v.csv"));
}

TEST_F(Program, without_any_device_says_in_a_sentence_what_to_install) {
    const TemporaryFolder empty;
    const std::vector<std::string> environment{"OCL_ICD_VENDORS=" + empty.path().string()};
    const std::string merl = folder / "m.csv";
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"devices"},
             {"devices", "--json"},
             {"eval", folder / "m.json", folder / "d.csv", "-o", folder / "v.csv"},
             {"eval", folder / "m.json", folder / "d.csv", "-o", folder / "v.csv", "--device", "0"},
             {"synth", folder / "m.json", folder / "v.csv"},
             {"fit", folder / "d.csv", "-m", "ward", "-o", folder / "out"}}) {
        const Outcome outcome = run_program(arguments, environment);
        EXPECT_EQ(outcome.status, 1) << arguments[0];
        EXPECT_EQ(outcome.out, "") << arguments[0];
        EXPECT_NE(outcome.err.find("pocl-opencl-icd"), std::string::npos) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "v.csv"));
    // What needs no device works.
    EXPECT_EQ(run_program({"models"}, environment).status, 0);
    EXPECT_EQ(run_program({"--version"}, environment).status, 0);
}

// PoCL has no device where it cannot keep kernels, and says nothing.
TEST_F(Program, names_the_folder_where_the_driver_cannot_keep_kernels) {
    if (test::device().platform != "Portable Computing Language" || list_devices().size() != 1)
        GTEST_SKIP() << "not the only device: PoCL's";
    write_file(folder / "file", "");
    std::filesystem::create_symlink("loop", folder / "loop");
    const std::string inside = folder / "file/x", loop = folder / "loop", file = folder / "file";
    for (const auto& [environment, says] :
         std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"POCL_CACHE_DIR=" + inside}, "'" + inside + "' (from POCL_CACHE_DIR)"},
             {{"POCL_CACHE_DIR=" + file}, "'" + file + "' (from POCL_CACHE_DIR)"}}) {
        const Outcome outcome = eval({}, environment);
        EXPECT_EQ(outcome.status, 1) << says;
        EXPECT_NE(outcome.err.find(says), std::string::npos) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "v.csv"));
    }
    EXPECT_EQ(eval({}, {"POCL_CACHE_DIR="}).status, 0); // as none
    // Variables as PoCL reads them.
    for (const auto& [variables, says] :
         std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"XDG_CACHE_HOME=" + loop}, "'" + loop + "/pocl/kcache' (from XDG_CACHE_HOME)"},
             {{"XDG_CACHE_HOME=", "HOME=" + file},
              "'" + file + "/.cache/pocl/kcache' (from HOME)"}}) {
        std::vector<std::string> command{"env", "-u", "POCL_CACHE_DIR"};
        command.insert(command.end(), variables.begin(), variables.end());
        command.insert(command.end(), {BRDFIT_PROGRAM, "devices"});
        const Outcome outcome = test::run_command(command);
        EXPECT_EQ(outcome.status, 1) << says;
        EXPECT_NE(outcome.err.find(says), std::string::npos) << outcome.err;
    }
}

TEST_F(Program, judges_the_form_asked_for_by_the_device_that_is_used) {
    const Outcome wrong = eval({}, {"BRDFIT_FORM=3,1,2048"});
    EXPECT_EQ(wrong.status, 2);
    EXPECT_NE(wrong.err.find(test::device().name), std::string::npos) << wrong.err;
    EXPECT_EQ(run_program({"devices"}, {"BRDFIT_FORM=3,1,2048"}).status, 0);
    EXPECT_EQ(eval({}, {"BRDFIT_FORM="}).status, 0);
    EXPECT_EQ(eval({}, {"BRDFIT_FORM=1,1,1024"}).status, 0);
}

TEST_F(Program, takes_kernels_from_the_folder_named_while_developing) {
    const KernelFolder kernels;
    EXPECT_EQ(eval({}, {"BRDFIT_KERNELS=" + kernels.path().string()}).status, 0);
    std::filesystem::remove(kernels / "models/ward.cl");
    const Outcome outcome = eval({}, {"BRDFIT_KERNELS=" + kernels.path().string()});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("models/ward.cl"), std::string::npos) << outcome.err;
}

TEST_F(Program, names_file_and_line_of_a_kernel_that_does_not_build) {
    for (const std::string file :
         {"models/ward.cl", "base/geometry.cl", "passes/prepare.cl", "passes/sums.cl"}) {
        const std::string source = test::kernel_text(file);
        // An error on a line of its own after the first statement.
        const std::size_t at = source.find(";\n") + 2;
        const auto line =
            1 + std::count(source.begin(), source.begin() + static_cast<std::ptrdiff_t>(at), '\n');
        std::string broken = source;
        broken.insert(at, "no_such_type x = 1;\n");
        const KernelFolder kernels(file, source, broken);
        const Outcome outcome = eval({}, {"BRDFIT_KERNELS=" + kernels.path().string()});
        EXPECT_EQ(outcome.status, 1) << file;
        EXPECT_NE(outcome.err.find(fmt::format("kernels/{}:{}:", file, line)), std::string::npos)
            << file << " line " << line << ": " << outcome.err;
        EXPECT_NE(outcome.err.find(test::device().name), std::string::npos) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "v.csv"));
    }
}

TEST_F(Program, a_fit_says_so_too_when_kernels_do_not_build) {
    ASSERT_EQ(run_program({"synth", folder / "m.json", folder / "data.csv", "--directions", "100"})
                  .status,
              0);
    const KernelFolder kernels("passes/gram.cl", "__kernel", "no_such_word __kernel");
    const Outcome outcome = run_program(
        {"fit", folder / "data.csv", "-m", "ward", "--lobes", "2", "-o", folder / "out"},
        {"BRDFIT_KERNELS=" + kernels.path().string()});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("kernels/passes/gram.cl:"), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
}

TEST(Messages, name_the_errors_of_opencl) {
    EXPECT_EQ(message_of(cl::Error(CL_OUT_OF_RESOURCES, "clFinish")),
              "OpenCL: clFinish failed: CL_OUT_OF_RESOURCES");
    EXPECT_EQ(message_of(cl::Error(CL_INVALID_WORK_GROUP_SIZE, "clEnqueueNDRangeKernel")),
              "OpenCL: clEnqueueNDRangeKernel failed: CL_INVALID_WORK_GROUP_SIZE");
    EXPECT_EQ(message_of(cl::Error(-9999, "clFinish")), "OpenCL: clFinish failed: error -9999");
    EXPECT_EQ(message_of(std::bad_alloc()), "out of memory");
    EXPECT_EQ(message_of(InputError("paint.csv: line 3")), "paint.csv: line 3");
}

} // namespace

} // namespace brdfit

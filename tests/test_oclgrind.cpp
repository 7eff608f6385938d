// The kernels under oclgrind, which interprets them and finds data races between work-items and
// accesses out of bounds, in the vector form of CPUs and the form of GPUs with its barriers.

#include "tests/support/support.hpp"

#include <cctype>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <iterator>
#include <sstream>

namespace brdfit::test {
namespace {

// A table of samples with all values negated.
std::string below_0(const std::string& table) {
    std::string below;
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
        if (!line.empty() && (std::isdigit(static_cast<unsigned char>(line[0])) != 0))
            for (std::size_t at = 0, commas = 0; at < line.size(); ++at)
                if (line[at] == ',' && ++commas >= 4)
                    line.insert(at + 1, "-");
        below += line + "\n";
    }
    return below;
}

class Oclgrind : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
        GTEST_SKIP() << "oclgrind and AddressSanitizer both want to be loaded first";
#endif
        if (run_command({"sh", "-c", "command -v oclgrind"}).status != 0)
            GTEST_SKIP() << "oclgrind is not installed";
        write_file(folder_ / "material.json", R"({"brdfit": 1, "channels": ["a", "b"],
            "diffuse": {"model": "kurt-coupled", "kd": [0.2, 0.1]},
            "lobes": [{"model": "kurt", "ks": [0.3, 0.2], "f0": 0.3, "m": 0.3, "alpha": 0.2},
                      {"model": "ward", "ks": [0.1, 0.1], "m": 0.15}]})");
        write_file(folder_ / "anisotropic.json", R"({"brdfit": 1, "channels": ["a"],
            "diffuse": {"model": "lambert", "kd": [0.2]},
            "lobes": [{"model": "cook-torrance", "ks": [0.3], "f0": 0.3, "m": 0.3},
                      {"model": "ashikhmin-shirley", "ks": [0.1], "f0": 0.5, "nu": 10, "nv": 90},
                      {"model": "kurt-plausible", "ks": [0.1], "f0": 0.5, "mx": 0.1, "my": 0.9}]})");
    }

    // Runs the program under oclgrind; the test fails on whatever that finds.
    void run(const std::string& arguments) {
        const std::string log = folder_ / "oclgrind.log";
        write_file(log, "");
        std::vector<std::string> command{"env",
                                         "-C",
                                         folder_.path(),
                                         "oclgrind",
                                         "--data-races",
                                         "--max-errors",
                                         "5",
                                         "--build-options",
                                         "-cl-opt-disable",
                                         "--log",
                                         log,
                                         BRDFIT_PROGRAM};
        std::istringstream words(arguments);
        command.insert(command.end(), std::istream_iterator<std::string>(words), {});
        const Outcome outcome = run_command(command, {fmt::format("BRDFIT_FORM={}", GetParam())});
        EXPECT_EQ(outcome.status, 0) << arguments << "\n" << outcome.out << outcome.err;
        EXPECT_EQ(read_file(log), "") << arguments;
    }

    TemporaryFolder folder_;
};

TEST_P(Oclgrind, finds_nothing_in_any_pass) {
    run("synth material.json scattered.csv --directions 150 --noise 0.02");
    // Every kind of pass, from a given start; with it the albedos of both components.
    write_file(folder_ / "start.json", R"({"brdfit": 1, "channels": ["a", "b"],
        "diffuse": {"model": "kurt-coupled", "kd": [0.2, 0.1]},
        "lobes": [{"model": "kurt", "ks": [0.3, 0.2], "f0": 0.2, "m": 0.25, "alpha": 0.1}]})");
    run("fit scattered.csv -m kurt-coupled --start start.json --max-evaluations 4 -o out");
    // Of data below 0, whose kd and ks are 0: albedos, most of the time of a fit, are not needed;
    // the search, one and several lobes, and each loss.
    write_file(folder_ / "below.csv", below_0(read_file(folder_ / "scattered.csv")));
    run("fit below.csv -m cook-torrance,ward+blinn-phong --max-evaluations 2 -o out --force");
    for (const char* metric : {"log", "cbrt"})
        run(fmt::format("fit below.csv -m ward --metric {} --max-evaluations 2 -o out --force",
                        metric));
}

TEST_P(Oclgrind, finds_nothing_in_anisotropic_lobes) {
    run("synth anisotropic.json scattered.csv --directions 100");
    write_file(folder_ / "below.csv", below_0(read_file(folder_ / "scattered.csv")));
    run("fit below.csv --anisotropic -m ashikhmin-shirley,kurt-plausible --max-evaluations 2 -o "
        "out");
}

TEST_P(Oclgrind, finds_nothing_in_sampling) {
    // One sequence a form, and lobes whose table is quickly made: it takes most of the time. Other
    // lobes are sampled for albedos.
    write_file(folder_ / "ward.json", R"({"brdfit": 1, "channels": ["a", "b"],
        "diffuse": {"model": "lambert", "kd": [0.2, 0.1]},
        "lobes": [{"model": "ward", "ks": [0.1, 0.1], "m": 0.15}]})");
    const char* const sequence = std::string(GetParam()).substr(0, 2) == "16" ? "philox" : "sobol";
    run(fmt::format("sample ward.json --wo 50,10 -n 99 --sequence {} -o s.csv", sequence));
    write_file(folder_ / "directions.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0.6,0,0.8\n"
                                           "0,0.6,0.8,0,-1,0\n0.6,0,-0.8,0,0,1\n");
    run("pdf ward.json directions.csv -o p.csv");
    run("eval anisotropic.json directions.csv -o v.csv");
}

// Pictures of a material and of measurements. Their work-items do not meet: one form tells.
class OclgrindOfPictures : public Oclgrind {};

TEST_P(OclgrindOfPictures, finds_nothing) {
    write_file(folder_ / "ward.json", R"({"brdfit": 1, "channels": ["a"],
        "diffuse": {"model": "lambert", "kd": [0.2]},
        "lobes": [{"model": "ward", "ks": [0.1], "mx": 0.15, "my": 0.3}]})");
    write_file(folder_ / "lambert.json", R"({"brdfit": 1, "channels": ["a"], "lobes": [],
        "diffuse": {"model": "lambert", "kd": [0.2]}})");
    run("render ward.json -o ward.exr --size 3x2 --samples 2 --shape ground --bounces 1 "
        "--light rectangle:2,-2,4,1,1,5 --light point:3,-4,5,60");
    run("synth ward.json scattered.csv --directions 50");
    run("render scattered.csv --proposal lambert.json -o scattered.exr --size 3x2 --samples 2 "
        "--shape cylinder");
}

INSTANTIATE_TEST_SUITE_P(Forms, Oclgrind, testing::Values("16,1,256", "1,16,64"),
                         [](const auto& info) {
                             return std::string(info.param).substr(0, 2) == "16" ? "cpu" : "gpu";
                         });

INSTANTIATE_TEST_SUITE_P(Forms, OclgrindOfPictures, testing::Values("16,1,256"));

} // namespace
} // namespace brdfit::test

#include "bench/native.hpp"
#include "bench/opencl.hpp"
#include "host/embedded.hpp"
#include "host/version.hpp"
#include "tests/support.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <set>

namespace brdfit::test {

namespace {

const std::vector<std::string> small = {"bench", "--samples", "3000"};

/// Kernels to run instead of those built in, with `from` in one of them replaced by `to`.
class ChangedKernels {
  public:
    ChangedKernels(const std::string& name, const std::string& from, const std::string& to) {
        for (const EmbeddedFile* file = embedded_kernels; file->name != nullptr; ++file) {
            std::string text = file->text;
            if (file->name == name) {
                const std::size_t place = text.find(from);
                if (place == std::string::npos)
                    throw std::runtime_error(name + " has no " + from);
                text.replace(place, from.size(), to);
            }
            const std::string path = folder_ / file->name;
            std::filesystem::create_directories(std::filesystem::path(path).parent_path());
            write_file(path, text);
        }
        setenv("BRDFIT_KERNELS", folder_.path().c_str(), 1);
    }
    ~ChangedKernels() { unsetenv("BRDFIT_KERNELS"); }
    ChangedKernels(const ChangedKernels&) = delete;
    ChangedKernels& operator=(const ChangedKernels&) = delete;

  private:
    TemporaryFolder folder_;
};

} // namespace

TEST(Bench, WritesEveryRowAndWhereItWasMeasured) {
    const TemporaryFolder folder;
    const std::string path = folder / "bench.json";
    std::vector<std::string> arguments = small;
    arguments.insert(arguments.end(), {"--json", path});
    const Outcome outcome = run_program(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("Msamples/s"), std::string::npos);
    EXPECT_NE(outcome.out.find("GB/s"), std::string::npos);

    const auto json = nlohmann::json::parse(read_file(path));
    const Device device = open_device();
    EXPECT_EQ(json.at("device"), device.name);
    EXPECT_EQ(json.at("driver"), device.driver);
    EXPECT_EQ(json.at("version"), version);
    EXPECT_EQ(json.at("kernels"), bench::kernel_hash());
    EXPECT_EQ(json.at("machine"), bench::processor_name());
    EXPECT_NEAR(json.at("samples").get<double>(), 3000, 30);

    std::set<std::tuple<std::string, std::string, int>> rows;
    for (const auto& row : json.at("results")) {
        EXPECT_EQ(row.at("model"), "kurt");
        EXPECT_GT(row.at("samples_per_second"), 0);
        EXPECT_GE(row.at("spread"), 0);
        EXPECT_LT(row.at("difference"), 1e-4);
        rows.emplace(row.at("device").get<std::string>(), row.at("work").get<std::string>(),
                     row.at("threads").get<int>());
    }
    EXPECT_EQ(rows.size(), json.at("results").size());
    const int all = static_cast<int>(device.compute_units);
    for (const char* work : {"error", "error-gradient"}) {
        EXPECT_EQ(rows.count({bench::baseline, work, 1}), 1);
        EXPECT_EQ(rows.count({"native scalar float64 precomputed", work, 1}), 1);
        EXPECT_EQ(rows.count({device.name, work, all}), 1);
        if (bench::can_run_on_one_thread(device)) {
            EXPECT_EQ(rows.count({device.name, work, 1}), 1);
        }
        if (bench::native_build().simd_flags != nullptr) {
            EXPECT_EQ(rows.count({"native openmp simd", work, 1}), 1);
        }
    }
}

TEST(Bench, GivesNoNumberForAWrongAnswer) {
    // A derivative a thousandth off.
    const ChangedKernels changed("models/kurt.cl", "g * minus_log_iz_oz",
                                 "1.001f * g * minus_log_iz_oz");
    const TemporaryFolder folder;
    const std::string path = folder / "bench.json";
    std::vector<std::string> arguments = small;
    arguments.insert(arguments.end(), {"--json", path});
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("error-gradient of kurt"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("1.0e-03"), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Bench, SummarisesRepeatedRuns) {
    const bench::Timing timing = bench::timing_of({5, 1, 3, 2, 4});
    EXPECT_EQ(timing.median, 3);
    EXPECT_DOUBLE_EQ(timing.spread, 2.0 / 3);
}

TEST(Bench, TakesTheLargestDifferenceOfAnAnswer) {
    EXPECT_DOUBLE_EQ(bench::difference({1, {2, 3}}, {1, {2, 4}}), 0.25);
    EXPECT_DOUBLE_EQ(bench::difference({1.5, {2}}, {1, {2}}), 0.5);
    EXPECT_EQ(bench::difference({0, {0}}, {0, {0}}), 0);
    EXPECT_TRUE(std::isinf(bench::difference({NAN, {2}}, {1, {2}})));
    EXPECT_TRUE(std::isinf(bench::difference({1, {}}, {1, {2}})));
}

TEST(BenchSampling, MeasuresGivenMaterials) {
    const TemporaryFolder folder;
    const std::string material = folder / "smooth.json", path = folder / "bench.json";
    write_file(material, R"({"brdfit": 1, "channels": ["Y"],
        "diffuse": {"model": "lambert", "kd": [0]},
        "lobes": [{"model": "ward-duer", "ks": [1], "m": 0.1}]})");
    const Outcome outcome =
        run_program({"bench", "sampling", material, "--theta", "30", "--json", path});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("smooth"), std::string::npos);
    const auto json = nlohmann::json::parse(read_file(path));
    ASSERT_EQ(json.at("results").size(), 1);
    const auto& row = json["results"][0];
    EXPECT_EQ(row.at("name"), "smooth");
    EXPECT_NEAR(row.at("albedo").get<double>(), 1, 0.05);
    EXPECT_LT(10 * row.at("variance").get<double>(), row.at("cosine_variance").get<double>());
    EXPECT_GT(row.at("sobol_samples_per_second"), 0);
    EXPECT_GT(row.at("philox_samples_per_second"), 0);
}

TEST(BenchSampling, RefusesBadCommandLines) {
    EXPECT_EQ(run_program({"bench", "sampling", "--theta", "90"}).status, 2);
    EXPECT_EQ(run_program({"bench", "sampling", "--no-such-option"}).status, 2);
    EXPECT_EQ(run_program({"bench", "samplings"}).status, 2);
    EXPECT_EQ(run_program({"bench", "sampling", "none.json"}).status, 1);
}

} // namespace brdfit::test

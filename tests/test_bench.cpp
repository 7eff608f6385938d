#include "bench/compare.hpp"
#include "bench/native/scalar.hpp"
#include "bench/native_tasks.hpp"
#include "bench/opencl.hpp"
#include "bench/portability.hpp"
#include "bench/report.hpp"
#include "host/device/kernels.hpp"
#include "host/embedded.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/model/structure.hpp"
#include "host/version.hpp"
#include "tests/support/cli.hpp"
#include "tests/support/reference_models.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <set>

namespace brdfit::test {

namespace {

// Every work on few samples, without whole fits (these need all) and compile times.
std::vector<std::string> small(const std::string& models, const std::string& works) {
    return {"bench", "--samples", "3000", "-m", models, "--work", works};
}
constexpr const char* all_works = "eval,error,sums,error-gradient,search,sample";

/// Kernels to run instead of those built in, with `from` in one of them replaced by `to`.
struct ChangedKernels {
    ChangedKernels(const std::string& file, const std::string& from, const std::string& to)
        : folder(file, from, to), variable("BRDFIT_KERNELS", folder.path().c_str()) {}
    KernelFolder folder;
    Variable variable;
};

} // namespace

TEST(Bench, writes_every_row_and_where_it_was_measured) {
    const TemporaryFolder folder;
    const std::string path = folder / "bench.json";
    std::vector<std::string> arguments = small("kurt,lambert", all_works);
    arguments.insert(arguments.end(), {"--json", path});
    const Outcome outcome = run_program(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    for (const char* text : {"million/s", "GB/s", "memory", "exp,log", "binds", "| target |"})
        EXPECT_NE(outcome.out.find(text), std::string::npos) << text;

    const auto json = nlohmann::json::parse(read_file(path));
    const Device device = open_device();
    EXPECT_EQ(json.at("device"), device.name);
    EXPECT_EQ(json.at("driver"), device.driver);
    EXPECT_EQ(json.at("version"), version);
    EXPECT_EQ(json.at("kernels"), kernel_hash());
    EXPECT_EQ(json.at("machine"), bench::processor_name());
    EXPECT_NEAR(json.at("samples").get<double>(), 3000, 30);

    std::set<std::tuple<std::string, std::string, std::string, int>> rows;
    for (const auto& row : json.at("results")) {
        EXPECT_GT(row.at("samples_per_second"), 0);
        EXPECT_GE(row.at("spread"), 0);
        EXPECT_LT(row.at("difference"), 2e-3);
        if (row.at("device") == device.name) {
            EXPECT_GT(row.at("gigabytes_per_second"), 0);
            EXPECT_GT(row.at("memory_share"), 0);
            EXPECT_GE(row.at("exp_log_share"), 0);
        }
        rows.emplace(row.at("device").get<std::string>(), row.at("work").get<std::string>(),
                     row.at("model").get<std::string>(), row.at("threads").get<int>());
    }
    EXPECT_EQ(rows.size(), json.at("results").size());
    const int all = static_cast<int>(device.compute_units);
    for (const bench::Work& work : bench::works)
        for (const char* model : {"kurt", "lambert"}) {
            if (std::string(work.name) == "search" && std::string(model) == "lambert")
                continue; // it has no shapes
            EXPECT_EQ(rows.count({bench::baseline, work.name, model, 1}), 1) << work.name;
            EXPECT_EQ(rows.count({device.name, work.name, model, all}), 1) << work.name;
            if (!bench::one_thread_environment(device).empty()) {
                EXPECT_EQ(rows.count({device.name, work.name, model, 1}), 1) << work.name;
            }
        }
    EXPECT_EQ(rows.count({bench::precomputed_baseline, "error-gradient", "kurt", 1}), 1);
    if (bench::native_build().simd_flags != nullptr) {
        EXPECT_EQ(rows.count({bench::simd_baseline, "error", "kurt", 1}), 1);
    }
    for (const auto& peaks : json.at("peaks")) {
        EXPECT_GT(peaks.at("exp_per_second"), 0);
        EXPECT_GT(peaks.at("log_per_second"), 0);
        for (const auto& reading : peaks.at("reading"))
            EXPECT_GT(reading.at("bytes_per_second"), 0);
    }

    // The file is what compare reads; nothing differs from itself.
    const Outcome same = run_program({"bench", "compare", path, path});
    EXPECT_EQ(run_program({"bench", "-m", "kurt", "compare", path, path}).status, 2);
    EXPECT_EQ(same.status, 0) << same.err;
    EXPECT_NE(same.out.find("0 slower, 0 faster"), std::string::npos) << same.out;
}

TEST(Bench, tells_how_well_devices_agree_with_float64) {
    const TemporaryFolder folder;
    const std::string path = folder / "portability.json";
    const std::vector<std::string> arguments{"bench",     "portability", "-m",     "kurt,lambert",
                                             "--samples", "3000",        "--json", path};
    const Outcome outcome = run_program(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.out << outcome.err;
    const auto json = nlohmann::json::parse(read_file(path));
    ASSERT_EQ(json.at("devices").size(), list_devices().size());
    std::set<std::string> kernels;
    for (const auto& row : json["devices"][0].at("differences")) {
        EXPECT_LT(row.at("difference"), row.at("tolerance"));
        kernels.insert(row.at("kernel").get<std::string>());
    }
    for (const char* kernel : {"values", "error", "sums", "error-gradient", "search", "sample"}) {
        EXPECT_EQ(kernels.count(kernel), 1) << kernel;
        EXPECT_NE(outcome.out.find(std::string("largest difference, ") + kernel),
                  std::string::npos);
    }
    EXPECT_EQ(run_program({"bench", "compare", path, path}).status, 0);

    // A wrong kernel is named, and no success.
    const ChangedKernels changed("models/kurt.cl", "g * minus_log_iz_oz",
                                 "1.001f * g * minus_log_iz_oz");
    const Outcome wrong = run_program({"bench", "portability", "-m", "kurt", "--samples", "3000"});
    EXPECT_EQ(wrong.status, 1);
    EXPECT_NE(wrong.out.find("kurt, WRONG"), std::string::npos) << wrong.out;
}

TEST(Bench, compares_the_albedos_of_devices) {
    std::vector<bench::Portability> devices(2);
    devices[0].albedos = {{"kurt", 0.5}};
    devices[1].albedos = {{"kurt", 0.5005}};
    bench::compare_albedos(devices);
    EXPECT_TRUE(devices[0].agreements.empty());
    ASSERT_EQ(devices[1].agreements.size(), 1U);
    EXPECT_NEAR(devices[1].agreements[0].difference, 1e-3, 1e-9);
    EXPECT_TRUE(devices[1].agreements[0].wrong());
    devices[0].failure = "crashed";
    const std::string table = bench::portability_table(devices);
    EXPECT_NE(table.find("| largest difference, albedo | - | 1.0e-03 kurt, WRONG |"),
              std::string::npos)
        << table;
    EXPECT_NE(table.find("crashed"), std::string::npos) << table;
}

TEST(Bench, gives_no_number_for_a_wrong_answer) {
    // A derivative a thousandth off.
    const ChangedKernels changed("models/kurt.cl", "g * minus_log_iz_oz",
                                 "1.001f * g * minus_log_iz_oz");
    const TemporaryFolder folder;
    const std::string path = folder / "bench.json";
    std::vector<std::string> arguments = small("kurt", "error-gradient");
    arguments.insert(arguments.end(), {"--json", path});
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("error-gradient of kurt"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("1.0e-03"), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Bench, knows_every_listed_model_that_needs_no_table) {
    std::set<std::string> names;
    for (const bench::Problem& problem : bench::problems())
        names.insert(problem.name());
    for (const char* name : {"lambert", "kurt", "kurt-coupled", "ggx", "beckmann-smith"})
        EXPECT_EQ(names.count(name), 1) << name;
    for (const Model& model : catalogue())
        if (model.listed() && names.count(model.name) == 0) {
            EXPECT_NE(kernel_source("models/" + model.name + ".cl").find("table"),
                      std::string::npos)
                << model.name;
        }
}

// The baseline, against the references written from the papers.
TEST(Bench, baseline_is_what_the_papers_say) {
    const auto directions = random_directions(2000, true, 3);
    Samples samples;
    samples.channels = {"R", "G", "B"};
    samples.directions = directions;
    samples.values.assign(3 * directions->count(), 0.1F);
    samples.weights.assign(directions->count(), 1);
    samples.valid.assign(directions->count(), 1);
    for (const bench::Problem& problem : bench::problems()) {
        const bench::ScalarModel& model = *bench::ScalarModel::find(problem.structure);
        const Material material = problem.material();
        std::vector<bench::ScalarSample> all = bench::scalar_samples(samples);
        std::vector<double> a, f(3 * all.size());
        for (std::size_t ch = 0; ch < 3; ++ch) {
            a.push_back(material.kd[ch]);
            a.push_back(material.lobes.empty() ? 0 : material.lobes[0].ks[ch]);
        }
        for (bench::ScalarSample& s : all) { // exactly unit vectors
            for (Vector* w : {&s.wi, &s.wo}) {
                const double length =
                    std::sqrt((*w)[0] * (*w)[0] + (*w)[1] * (*w)[1] + (*w)[2] * (*w)[2]);
                for (double& x : *w)
                    x /= length;
            }
        }
        model.evaluate(all, problem.theta.data(), a.data(), f.data());
        for (std::size_t k = 0; k < all.size(); k += 7) {
            const double expected = reference_evaluate(material, 1, all[k].wi, all[k].wo);
            EXPECT_NEAR(f[3 * k + 1], expected, 2e-6 * std::abs(expected) + 1e-12)
                << problem.name() << " " << k;
        }
    }
}

TEST(Bench, baseline_derivatives_are_those_of_its_error) {
    const Samples samples = bench::data_of(open_device(), 1000);
    const std::vector<bench::ScalarSample> all = bench::scalar_samples(samples);
    for (const bench::Problem& problem : bench::problems()) {
        const bench::ScalarModel& model = *bench::ScalarModel::find(problem.structure);
        const int parameters = static_cast<int>(problem.theta.size());
        const auto error = [&](const std::vector<double>& theta, bool gradient) {
            return bench::solved(model,
                                 model.sums(all, theta.data(), parameters,
                                            gradient ? bench::Sums::Gradient : bench::Sums::Basis),
                                 parameters, gradient, all.size());
        };
        const bench::Answer answer = error(problem.theta, true);
        for (std::size_t p = 0; p < problem.theta.size(); ++p) {
            const double step = 1e-4 * problem.theta[p];
            std::vector<double> above = problem.theta, below = problem.theta;
            above[p] += step;
            below[p] -= step;
            const double expected = (error(above, false)[0] - error(below, false)[0]) / (2 * step);
            EXPECT_NEAR(answer[1 + p], expected,
                        1e-4 * std::abs(expected) + 1e-5 * answer[0] / std::abs(problem.theta[p]))
                << problem.name() << " " << p;
        }
    }
}

TEST(Bench, summarises_repeated_runs) {
    const bench::Timing timing = bench::timing_of({5, 1, 3, 2, 4});
    EXPECT_EQ(timing.median, 3);
    EXPECT_DOUBLE_EQ(timing.spread, 2.0 / 3);
}

TEST(Bench, takes_the_largest_difference_of_an_answer) {
    EXPECT_DOUBLE_EQ(bench::difference({1, 2, 3}, {1, 2, 4}), 0.25);
    EXPECT_DOUBLE_EQ(bench::difference({1.5, 2}, {1, 2}), 0.5);
    EXPECT_DOUBLE_EQ(bench::difference({1, 2e-4}, {1, 1e-4}), 0.01); // a hundredth of the first
    EXPECT_EQ(bench::difference({0, 0}, {0, 0}), 0);
    EXPECT_TRUE(std::isinf(bench::difference({NAN, 2}, {1, 2})));
    EXPECT_TRUE(std::isinf(bench::difference({1}, {1, 2})));
}

TEST(Bench, says_what_binds) {
    bench::Peaks peaks{"d", 1, 2e9, 1e9, {{1e6, 40e9}, {1e8, 10e9}}};
    EXPECT_DOUBLE_EQ(peaks.bytes_per_second(1e5), 40e9);
    EXPECT_DOUBLE_EQ(peaks.bytes_per_second(1e9), 10e9);
    EXPECT_NEAR(peaks.bytes_per_second(1e7), 25e9, 1);
    bench::Result result;
    result.samples_per_second = 1e9;
    result.bytes_per_sample = 8;
    result.working_set = 1e9;
    EXPECT_DOUBLE_EQ(peaks.memory_share(result), 0.8);
    EXPECT_STREQ(peaks.binds(result), "memory");
    result.bytes_per_sample = 1;
    EXPECT_STREQ(peaks.binds(result), "other");
    result.calls = {1, 0.3};
    EXPECT_DOUBLE_EQ(peaks.calls_share(result), 0.8);
    EXPECT_STREQ(peaks.binds(result), "exp, log");
}

TEST(Bench, refuses_bad_command_lines) {
    EXPECT_EQ(run_program({"bench", "-m", "phong"}).status, 2);
    EXPECT_EQ(run_program({"bench", "--work", "everything"}).status, 2);
    test::expect_usage_error(run_program({"bench", "--work", "read,render", "-m", "kurt"}),
                             "--model: --work read,render is of no model");
    EXPECT_EQ(run_program({"bench", "--device", "no such device"}).status, 2);
    EXPECT_EQ(run_program({"bench", "-m", "lambert", "--json", "/no/such/folder/x.json"}).status,
              1);
}

namespace {

// What compare needs of a file, with a row for each speed and spread.
std::string record(const std::vector<std::pair<double, double>>& rows) {
    nlohmann::json json = {{"machine", "m"}, {"results", nlohmann::json::array()}};
    for (std::size_t i = 0; i < rows.size(); ++i)
        json["results"].push_back({{"device", "d"},
                                   {"work", "eval"},
                                   {"model", "model" + std::to_string(i)},
                                   {"threads", 1},
                                   {"samples_per_second", rows[i].first},
                                   {"spread", rows[i].second}});
    return json.dump();
}

} // namespace

TEST(BenchCompare, tells_what_got_slower_from_noise) {
    const TemporaryFolder folder;
    const std::string before = folder / "before.json", after = folder / "after.json";
    // Slower; slower within the spreads; slower by less than 5 %; faster; gone.
    write_file(before, record({{100, 0.01}, {100, 0.2}, {100, 0}, {100, 0.01}, {100, 0}}));
    write_file(after, record({{80, 0.01}, {80, 0.1}, {96, 0}, {120, 0.01}}));
    const Outcome outcome = run_program({"bench", "compare", before, after});
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_NE(outcome.out.find("1 slower, 1 faster, 2 the same within noise"), std::string::npos)
        << outcome.out;
    EXPECT_NE(outcome.out.find("slower  -20.0%"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("only in " + before + ": eval of model4"), std::string::npos)
        << outcome.out;

    const Outcome back = run_program({"bench", "compare", after, after, "--json"});
    EXPECT_EQ(back.status, 0);
    const auto rows = nlohmann::json::parse(back.out);
    ASSERT_EQ(rows.size(), 4);
    EXPECT_EQ(rows[0].at("verdict"), "same");
    EXPECT_EQ(run_program({"bench", "compare", before, after, "--least", "30"}).status, 0);
}

TEST(BenchCompare, names_what_is_wrong_with_a_file) {
    const TemporaryFolder folder;
    const std::string good = folder / "good.json", bad = folder / "bad.json";
    write_file(good, record({{100, 0.01}}));
    for (const char* text :
         {"", "{", "[]", R"({"results": 3})", R"({"results": [{"device": "d"}]})",
          R"({"results": [{"device": "d", "work": "eval", "model": "m", "threads": 1,
              "samples_per_second": 0, "spread": 0}]})",
          R"({"results": [{"device": "d", "work": "eval", "model": "m", "threads": "1",
              "samples_per_second": 1, "spread": 0}]})"}) {
        write_file(bad, text);
        const Outcome outcome = run_program({"bench", "compare", good, bad});
        EXPECT_EQ(outcome.status, 1) << text;
        EXPECT_NE(outcome.err.find(bad), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(run_program({"bench", "compare", good}).status, 2);
    EXPECT_EQ(run_program({"bench", "compare", good, folder / "none.json"}).status, 1);
}

TEST(BenchSampling, measures_given_materials) {
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

TEST(BenchSampling, refuses_bad_command_lines) {
    EXPECT_EQ(run_program({"bench", "sampling", "--theta", "90"}).status, 2);
    EXPECT_EQ(run_program({"bench", "sampling", "--no-such-option"}).status, 2);
    EXPECT_EQ(run_program({"bench", "samplings"}).status, 2);
    EXPECT_EQ(run_program({"bench", "sampling", "none.json"}).status, 1);
}

} // namespace brdfit::test

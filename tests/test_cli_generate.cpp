// brdfit generate on the command line, and the other commands on what it makes.

#include "tests/support/support.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

namespace brdfit::test {

namespace {

using nlohmann::json;

class Generate : public testing::Test {
  protected:
    TemporaryFolder folder;
    std::string gauss = folder / "gauss.json", table = folder / "gauss.exr";
    void SetUp() override {
        write_file(gauss, R"({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.2})");
    }
};

} // namespace

TEST_F(Generate, makes_tables_that_every_command_takes) {
    const Outcome made = run_program({"generate", gauss, "-o", table, "--ward", "--json"});
    ASSERT_EQ(made.status, 0) << made.err;
    const json report = json::parse(made.out);
    EXPECT_EQ(report["points"], 200);
    EXPECT_TRUE(report["mean_is_normal"]);
    // Fig. 6: R stays above 0.9 where Ward's falls to 0.11 at 89 degrees.
    const json last = report["beside_ward"].back();
    EXPECT_EQ(last["theta"], 89);
    EXPECT_GT(last["microfacet"], 0.9);
    EXPECT_NEAR(last["ward"].get<double>(), 0.11, 0.01);

    // Of a metal R is f0 and more until f0 comes near 1: nothing is left, not a constant of 1e5.
    for (const json& constant : report["diffuse_constant"]) {
        const bool left = !constant["metal"] || constant["f0"] > 0.5;
        EXPECT_EQ(constant["c"].is_number(), left) << constant;
        if (left) {
            EXPECT_GE(constant["c"], 0.318) << constant;
            EXPECT_LT(constant["c"], 1e3) << constant;
        }
    }
    const Outcome printed =
        run_program({"generate", gauss, "-o", table, "--preview", folder / "g.png"});
    EXPECT_EQ(read_file(folder / "g.png").substr(1, 3), "PNG");
    EXPECT_NE(printed.err.find("R1_correlated (white "), std::string::npos) << printed.err;
    EXPECT_NE(printed.out.find("none (f0 0)"), std::string::npos) << printed.out;
    EXPECT_NE(printed.out.find("nothing is left"), std::string::npos) << printed.out;

    write_file(folder / "m.json",
               R"({"brdfit": 1, "channels": ["Y"], "diffuse": {"model": "microfacet", "kd": [0.5]},
                   "lobes": [{"model": "microfacet", "ks": [1], "f0": 0.9, "table": "gauss.exr",
                              "correlated": true}]})");
    write_file(folder / "d.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0.6,0.8\n0,0,1,0,0,1\n");
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"eval", folder / "m.json", folder / "d.csv", "-o",
                                   folder / "v.csv"},
          {"pdf", folder / "m.json", folder / "d.csv", "-o", folder / "p.csv"},
          {"sample", folder / "m.json", "--wo", "30,0", "-n", "100", "-o", folder / "s.csv"},
          {"synth", folder / "m.json", folder / "y.csv", "--directions", "50"}}) {
        const Outcome outcome = run_program(command);
        EXPECT_EQ(outcome.status, 0) << command[0] << outcome.err;
    }
    // Moved away from its material.
    std::filesystem::remove(table);
    const Outcome moved =
        run_program({"eval", folder / "m.json", folder / "d.csv", "-o", folder / "v.csv"});
    EXPECT_EQ(moved.status, 1);
    EXPECT_NE(moved.err.find("gauss.exr"), std::string::npos) << moved.err;
    EXPECT_NE(moved.err.find("lobes[0].table"), std::string::npos) << moved.err;
}

TEST_F(Generate, refuses_wrong_usage_and_leaves_nothing) {
    EXPECT_EQ(run_program({"generate", "-o", table}).status, 2);
    EXPECT_EQ(run_program({"generate", gauss, "--from", gauss, "-o", table}).status, 2);
    EXPECT_EQ(run_program({"generate", gauss, "-o", table, "--points", "3"}).status, 2);
    EXPECT_EQ(run_program({"generate", gauss, "-o", table, "--lambertian"}).status, 2);
    write_file(folder / "bad.json", R"({"distribution": "gaussian", "sigma": -1})");
    const Outcome bad = run_program({"generate", folder / "bad.json", "-o", table});
    EXPECT_EQ(bad.status, 1);
    EXPECT_NE(bad.err.find("bad.json: sigma"), std::string::npos) << bad.err;
    EXPECT_EQ(run_program({"generate", "--from", folder / "bad.json", "-o", table}).status, 1);
    EXPECT_EQ(run_program({"generate", "--from", gauss, "-m", "nonsense", "-o", table}).status, 2);
    EXPECT_FALSE(std::filesystem::exists(table));
    const Outcome fitted = run_program({"fit", gauss, "-m", "microfacet", "-o", folder / "out"});
    EXPECT_EQ(fitted.status, 2);
    EXPECT_NE(fitted.err.find("generate --from"), std::string::npos) << fitted.err;
    const Outcome listed = run_program({"models", "microfacet"});
    EXPECT_NE(listed.out.find("with a table"), std::string::npos);
}

TEST_F(Generate, refuses_options_that_do_not_apply_before_any_work) {
    const auto refuses = [&](std::vector<std::string> options, const std::string& name) {
        options.insert(options.begin(), "generate");
        const Outcome outcome = run_program(options);
        EXPECT_EQ(outcome.status, 2) << outcome.err;
        EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
    };
    refuses({gauss, "-m", "ward", "-o", table}, "--model");
    refuses({gauss, "--max-theta", "70", "-o", table}, "--max-theta");
    refuses({gauss, "--isotropic", "-o", table}, "--isotropic");
    refuses({"--from", gauss, "--ward", "-o", table}, "--ward");
    write_file(folder / "satin.json", R"({"distribution": "satin"})");
    refuses({folder / "satin.json", "--ward", "-o", table}, "--ward");
    refuses({gauss, "-o", folder / "gauss.png"}, "gauss.png");
    refuses({"--from", gauss, "-o", folder / "gauss.json"}, "gauss.json");
    EXPECT_FALSE(std::filesystem::exists(table));
    EXPECT_EQ(run_program({"table", "--list", "--size", "4"}).status, 2);
    EXPECT_EQ(run_program({"table", "--list", "-q"}).status, 0);
    write_file(folder / "m.json",
               R"({"brdfit": 1, "channels": ["Y"], "diffuse": {"model": "lambert", "kd": [0.2]}})");
    EXPECT_EQ(
        run_program({"albedo", folder / "m.json", "--isotropic", "-o", folder / "a.csv"}).status,
        2);
}

// The nodes of 40 parts are 1.3 GiB.
TEST_F(Generate, takes_mixtures_of_many_parts_in_little_memory) {
    json mixture = {{"distribution", "mixture"}, {"parts", json::array()}};
    for (int i = 0; i < 40; ++i)
        mixture["parts"].push_back({{"distribution", "gaussian"},
                                    {"sigma", 0.1},
                                    {"tilt", 0.01 * i},
                                    {"turn", 0.15 * i},
                                    {"weight", 1}});
    write_file(folder / "many.json", mixture.dump());
    const Outcome made =
        run_program({"generate", folder / "many.json", "-o", table, "--points", "16"});
    EXPECT_EQ(made.status, 0) << made.err;
    rusage usage{}; // the largest of all children
    getrusage(RUSAGE_CHILDREN, &usage);
    EXPECT_LT(usage.ru_maxrss, 1 << 20) << "KiB";
}

TEST_F(Generate, from_a_file_does_not_replace_a_material_beside_the_table) {
    const std::string material = folder / "gauss.json";
    const std::string before = read_file(material);
    const Outcome outcome = run_program({"generate", "--from", gauss, "-o", folder / "gauss.exr"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("--force"), std::string::npos) << outcome.err;
    EXPECT_EQ(read_file(material), before);
    EXPECT_EQ(run_program({"generate", gauss, "--force", "-o", table}).status, 2);
}

TEST_F(Generate, recovers_from_a_file_and_compares) {
    write_file(folder / "m.json",
               R"({"brdfit": 1, "channels": ["Y"], "diffuse": {"model": "lambert", "kd": [0.2]},
                   "lobes": [{"model": "kurt", "ks": [0.5], "f0": 0.5, "m": 0.3, "alpha": 0.3}]})");
    ASSERT_EQ(
        run_program({"synth", folder / "m.json", folder / "y.csv", "--directions", "3000"}).status,
        0);
    const Outcome outcome = run_program({"generate", "--from", folder / "y.csv", "--isotropic",
                                         "-m", "ward", "-o", folder / "y.exr", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json rows = json::parse(outcome.out);
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0]["model"], "microfacet");
    EXPECT_LT(rows[0]["error"]["ngan"], rows[1]["error"]["ngan"]);
    for (const json& row : rows) {
        EXPECT_EQ(row["error_outside_peak"]["theta_h"], 20);
        EXPECT_GT(row["error_outside_peak"]["ngan"], 0);
    }
    EXPECT_LT(rows[0]["error_outside_peak"]["ngan"], rows[1]["error_outside_peak"]["ngan"]);
    write_file(folder / "d.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    EXPECT_EQ(
        run_program({"eval", folder / "y.json", folder / "d.csv", "-o", folder / "v.csv"}).status,
        0);
}

} // namespace brdfit::test

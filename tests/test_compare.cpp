// brdfit compare: the errors it states, where they are, and what it refuses.

#include "fit/compare.hpp"
#include "host/image/map.hpp"
#include "host/measured/merl.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/cli.hpp"
#include "tests/support/measured.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <regex>

namespace brdfit {

namespace {

using namespace test;
using nlohmann::json;

class Compare : public Cli {
  protected:
    std::string in(const std::string& name) const { return folder / name; }
    json compared(const std::string& a, const std::string& b,
                  const std::vector<std::string>& options = {}) const {
        std::vector<std::string> arguments{"compare", in(a), in(b), "--json"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return json::parse(outcome.out);
    }
};

TEST_F(Compare, of_a_measurement_with_its_fit_has_the_errors_of_the_fit) {
    ASSERT_EQ(fit({"-m", "ward"}).status, 0);
    const Material material = written("paint.ward.1.json");
    const json result = compared("paint.csv", "out/paint.ward.1.json");
    for (const char* metric : {"ngan", "l2", "log", "cbrt"})
        EXPECT_NEAR(result["errors"][metric].get<double>(), material.fit["error"][metric],
                    1e-5 * material.fit["error"][metric].get<double>())
            << metric;
    EXPECT_EQ(result["samples"], material.fit["samples"].get<std::size_t>());
    EXPECT_EQ(result["at"], "the samples of " + in("paint.csv"));
    // The other way round the samples are the same and what is relative is so to the fit.
    const json turned = compared("out/paint.ward.1.json", "paint.csv");
    EXPECT_EQ(turned["at"], result["at"]);
    EXPECT_NEAR(turned["errors"]["ngan"].get<double>(), result["errors"]["ngan"], 1e-7);
    EXPECT_LT(turned["bias"].get<double>() * result["bias"].get<double>(), 0);
}

TEST_F(Compare, of_a_brighter_material_is_as_much_everywhere) {
    const std::string paint = read_file(in("paint.json"));
    write_file(in("bright.json"), changed(changed(paint, "[0.1, 0.2, 0.3]", "[0.11, 0.22, 0.33]"),
                                          "[0.5, 0.4, 0.3]", "[0.55, 0.44, 0.33]"));
    const json result = compared("paint.json", "bright.json");
    EXPECT_EQ(result["at"], "the centres of MERL's bins");
    EXPECT_NEAR(result["bias"].get<double>(), 0.1, 1e-5);
    for (const char* name : {"median", "p95", "largest"})
        EXPECT_NEAR(result["relative"][name].get<double>(), 0.1, 1e-5) << name;
    for (const char* angle : {"theta_i", "theta_h", "theta_d"}) {
        double share = 0;
        std::size_t samples = 0;
        for (const json& band : result["bands"][angle]) {
            EXPECT_NEAR(band["bias"].get<double>(), 0.1, 1e-5);
            share += band["share"].get<double>();
            samples += band["samples"].get<std::size_t>();
        }
        EXPECT_NEAR(share, 1, 1e-9) << angle;
        EXPECT_EQ(samples, result["samples"]) << angle;
    }
}

TEST_F(Compare, with_an_anisotropic_material_reaches_all_azimuths) {
    const json result = compared("paint.json", "brushed.json");
    EXPECT_EQ(result["at"], "the centres of MERL's bins, turned to all azimuths");
    // A turned frame is another material, but one with the same distance to what is isotropic.
    const std::string brushed = read_file(in("brushed.json"));
    write_file(in("turned.json"),
               changed(brushed, "\"mx\": 0.2, \"my\": 0.4", "\"mx\": 0.4, \"my\": 0.2"));
    const json other = compared("paint.json", "turned.json");
    EXPECT_NEAR(result["errors"]["ngan"].get<double>(), other["errors"]["ngan"],
                0.01 * other["errors"]["ngan"].get<double>());
    EXPECT_GT(compared("brushed.json", "turned.json")["errors"]["ngan"].get<double>(), 0.01);
}

TEST_F(Compare, of_two_grids_alike_takes_their_values) {
    ASSERT_EQ(run_program({"synth", in("paint.json"), in("paint.binary")}).status, 0);
    const json same = compared("paint.binary", "paint.binary");
    EXPECT_EQ(same["errors"]["ngan"], 0);
    EXPECT_EQ(same["relative"]["largest"], 0);
    EXPECT_LT(compared("paint.binary", "paint.json")["relative"]["largest"].get<double>(), 1e-5);
}

TEST_F(Compare, names_the_worst_samples) {
    const std::string head = "theta_i,phi_i,theta_o,phi_o,R,G\n";
    std::string a = head, b = head;
    for (int i = 0; i < 50; ++i) {
        const double theta_o = 0.02 * i;
        a += fmt::format("0.5,0,{},1,0.5,0.25\n", theta_o);
        b += fmt::format("0.5,0,{},1,{},{}\n", theta_o, i == 20 ? 2.5 : 0.5, i == 30 ? 0.5 : 0.25);
    }
    write_file(in("a.csv"), a);
    write_file(in("b.csv"), b);
    const json result = compared("a.csv", "b.csv", {"--worst", "2"});
    ASSERT_EQ(result["worst"].size(), 2U);
    const json& worst = result["worst"][0];
    EXPECT_NEAR(worst["theta_o"].get<double>(), 0.4 / degree, 1e-4);
    EXPECT_NEAR(worst["theta_i"].get<double>(), 0.5 / degree, 1e-4);
    EXPECT_NEAR(worst["phi_o"].get<double>(), 1 / degree, 1e-4);
    EXPECT_EQ(worst["a"], json({0.5, 0.25}));
    EXPECT_EQ(worst["b"], json({2.5, 0.25}));
    EXPECT_NEAR(worst["difference"].get<double>(), std::cos(0.5) * 2 / std::sqrt(2), 1e-6);
    EXPECT_NEAR(worst["relative"].get<double>(), 2 / 0.75, 1e-6);
    EXPECT_NEAR(result["worst"][1]["theta_o"].get<double>(), 0.6 / degree, 1e-4);
    EXPECT_EQ(result["largest_relative"], worst);
    EXPECT_EQ(result["relative"]["median"], 0);
    const Vector wi = direction(0.5, 0), wo = direction(0.4, 1);
    const double cos_2d = test::dot(wi, wo);
    EXPECT_NEAR(worst["theta_d"].get<double>(), std::acos(cos_2d) / 2 / degree, 1e-3);
}

TEST_F(Compare, leaves_samples_where_a_is_zero_out_of_relative_errors) {
    const std::string head = "theta_i,phi_i,theta_o,phi_o,R\n";
    write_file(in("a.csv"), head + "0.5,0,0.25,1,0\n0.5,0,0.5,1,1\n0.5,0,0.75,1,1\n");
    write_file(in("b.csv"), head + "0.5,0,0.25,1,1\n0.5,0,0.5,1,1.5\n0.5,0,0.75,1,1.5\n");
    const json result = compared("a.csv", "b.csv");
    EXPECT_EQ(result["relative"]["a_is_zero"], 1);
    EXPECT_NEAR(result["relative"]["largest"].get<double>(), 0.5, 1e-6);
    const Outcome text = run_program({"compare", in("a.csv"), in("b.csv")});
    EXPECT_EQ(text.status, 0) << text.err;
    EXPECT_NE(text.out.find("without 1 where A is 0"), std::string::npos) << text.out;
    EXPECT_EQ(text.out.find("nan"), std::string::npos) << text.out;
}

TEST_F(Compare, takes_the_channels_that_both_have) {
    const std::string rows = "0.5,0,0.25,1,0.5,0.25\n0.5,0,0.75,1,0.5,0.25\n";
    const std::string head = "theta_i,phi_i,theta_o,phi_o,";
    write_file(in("rg.csv"), head + "R,G\n" + rows);
    write_file(in("gb.csv"), head + "B,G\n" + rows);
    write_file(in("xy.csv"), head + "X,Y\n" + rows);
    const json result = compared("rg.csv", "gb.csv");
    EXPECT_EQ(result["channels"], json({"G"}));
    EXPECT_EQ(result["errors"]["ngan"], 0);
    expect_input_error(run_program({"compare", in("rg.csv"), in("xy.csv")}),
                       "expected some in common, or one each");
}

TEST_F(Compare, draws_a_map) {
    const Outcome outcome =
        run_program({"compare", in("paint.csv"), in("paint.json"), "--svg", in("map.svg")});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::string svg = read_file(in("map.svg"));
    EXPECT_EQ(svg.find("<svg"), 0U);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    const std::regex cell("class=\"cell\"");
    const auto cells =
        std::distance(std::sregex_iterator(svg.begin(), svg.end(), cell), std::sregex_iterator());
    EXPECT_GT(cells, 100);
    EXPECT_LT(cells, 600); // 600 samples reach no more
}

TEST_F(Compare, map_has_the_colours_of_its_values) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Map map;
    map.x = {0, 1, 4};
    map.y = {0, 45, 90};
    map.x_ticks = {0, 4};
    map.y_ticks = {45};
    map.values = {-0.2, 0, nan, 0.2};
    write_map(map, in("map.svg"));
    const std::string svg = read_file(in("map.svg"));
    EXPECT_NE(svg.find("fill=\"#2166ac\"><title>-0.2<"), std::string::npos) << svg;
    EXPECT_NE(svg.find("fill=\"#ffffff\"><title>0<"), std::string::npos);
    EXPECT_NE(svg.find("fill=\"#b2182b\"><title>0.2<"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST_F(Compare, refuses_what_it_cannot_do) {
    const std::string paint = in("paint.json"), csv = in("paint.csv");
    expect_usage_error(run_program({"compare", paint}), "B is required");
    expect_usage_error(run_program({"compare", paint, csv, "--svg", in("map.png")}),
                       "expected .svg");
    expect_usage_error(run_program({"compare", paint, csv, "--max-theta", "nan"}), "--max-theta");
    expect_usage_error(run_program({"compare", paint, in("brushed.json"), "--isotropic"}),
                       "expected them with measured files");
    expect_input_error(run_program({"compare", paint, in("none.csv")}), "none.csv");
    write_file(in("page.bsdf"), "<!DOCTYPE html><html></html>");
    expect_input_error(run_program({"compare", paint, in("page.bsdf")}), "HTML");
    write_file(in("high.csv"), "theta_i,phi_i,theta_o,phi_o,R\n1.5,0,0.25,1,0.5\n");
    expect_input_error(run_program({"compare", in("high.csv"), in("high.csv")}),
                       "within 80 degrees");
    EXPECT_FALSE(std::filesystem::exists(in("map.png")));
}

} // namespace

} // namespace brdfit

// Albedo tables: entries against float64 quadrature in each renderer's layout, formats,
// specifications.
#include "host/albedo/integrator.hpp"
#include "host/error.hpp"
#include "host/image/image.hpp"
#include "host/parallel.hpp"
#include "host/table/table.hpp"
#include "tests/support/albedo_reference.hpp"
#include "tests/support/support.hpp"

#include <Imath/half.h>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

namespace brdfit {
namespace {

using test::device;
using test::run_program;
using test::TemporaryFolder;

/// A preset of another size and tolerance.
TableSpec preset(const std::string& name, std::size_t size, double tolerance) {
    const TableSpec* const found = find_preset(name);
    EXPECT_NE(found, nullptr) << name;
    TableSpec spec = *found;
    if (size > 0)
        set_size(spec, size);
    spec.tolerance = tolerance;
    return spec;
}

/// expected(x, y) for every entry of two axes, fastest first, in float64 on all cores.
template <typename Expected>
void expect_entries(const Table& table, std::size_t channel, double tolerance, Expected expected) {
    const std::size_t width = table.spec.axes[0].size, entries = table.values[channel].size();
    std::vector<double> values(entries);
    parallel_pieces(entries, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e)
            values[e] = expected(static_cast<double>(e % width), static_cast<double>(e / width));
    });
    for (std::size_t e = 0; e < entries; ++e)
        EXPECT_NEAR(table.values[channel][e], values[e], tolerance)
            << "entry " << e % width << ", " << e / width;
}

// All 32 x 32 entries of the true size: x roughness, y mu, corners at least 1e-4, alpha =
// roughness^2.
TEST(CyclesTable, agrees_with_quadrature) {
    const Table table = compute_table(device(), preset("cycles", 0, 2e-5));
    ASSERT_EQ(table.values[0].size(), 1024U);
    expect_entries(table, 0, 2e-5, [](double x, double y) {
        const double rough = std::max(x / 31, 1e-4), mu = std::max(y / 31, 1e-4);
        return test::ggx_albedo(mu, rough * rough).all;
    });
}

TEST(Table, tells_its_progress) {
    const std::vector<double> shares = test::told_shares([](const ProgressFunction& progress) {
        compute_table(device(), *find_preset("openpbr-average"), progress);
    });
    EXPECT_GT(shares.back(), 0.5);
}

// Entries that Cycles ships.
TEST(CyclesTable, holds_the_published_entries) {
    const Table table = compute_table(device(), *find_preset("cycles"));
    const double second_row[] = {1.000000, 0.999451, 0.990086, 0.954714};
    for (std::size_t x = 0; x < 4; ++x)
        EXPECT_NEAR(table.values[0][32 + x], second_row[x], 5e-6);
    const Table average = compute_table(device(), *find_preset("cycles-average"));
    ASSERT_EQ(average.values[0].size(), 32U);
    for (const auto& [x, value] : {std::pair(0, 1.0),
                                   {3, 0.999548},
                                   {8, 0.985805},
                                   {16, 0.870874},
                                   {24, 0.631068},
                                   {31, 0.409137}})
        EXPECT_NEAR(average.values[0][static_cast<std::size_t>(x)], value, 5e-6);
}

// x: NoV = (x + 0.5) / w; y: coord = min(1, (h - y + 0.5) / h), alpha = coord^2.
TEST(FilamentTable, agrees_with_quadrature) {
    constexpr std::size_t size = 24;
    const Table table = compute_table(device(), preset("filament", size, 1e-4));
    const Table single = compute_table(device(), preset("filament-single", size, 1e-4));
    for (const std::size_t part : {0U, 1U}) {
        const auto value = [part](double x, double y, bool multiple) {
            const double coord = std::min(1.0, (size - y + 0.5) / size);
            const test::GgxAlbedo e = test::ggx_albedo((x + 0.5) / size, coord * coord);
            if (multiple)
                return part == 0 ? e.weighted : e.all;
            return part == 0 ? e.all - e.weighted : e.weighted;
        };
        expect_entries(table, part, 1e-4, [&](double x, double y) { return value(x, y, true); });
        expect_entries(single, part, 1e-4, [&](double x, double y) { return value(x, y, false); });
    }
    // The true size: corners and a middle.
    const TableSpec& full = *find_preset("filament");
    EXPECT_EQ(full.entries(), 128U * 128U);
    EXPECT_EQ(full.axes[1].value(0), 1);
    EXPECT_NEAR(full.axes[1].value(127), std::pow(1.5 / 128, 2), 1e-12);
}

// 1 - E of GGX whose G2 is G1(wi) G1(wo), cosine fastest, sqrt(alpha) along the other axis.
TEST(OpenPbrTable, agrees_with_quadrature) {
    constexpr std::size_t size = 12;
    const Table table = compute_table(device(), preset("openpbr", size, 2e-5));
    expect_entries(table, 0, 2e-5, [](double x, double y) {
        const double mu = std::max(x / (size - 1), 1e-4), alpha = std::pow(y / (size - 1), 2);
        if (alpha == 0)
            return 0.0;
        const Vector wo{std::sqrt(1 - mu * mu), 0, mu};
        return 1 - test::reference_albedo("ggx-uncorrelated", true, {1, alpha}, wo, alpha);
    });
}

// The published average is a Monte Carlo result: 0, 0, 7, 30, 85, 188, 353. Its noise is a percent.
TEST(OpenPbrTable, comes_close_to_the_published_average) {
    const Table table = compute_table(device(), *find_preset("openpbr-average"));
    const double published[] = {0, 0, 7, 30, 85, 188, 353};
    for (std::size_t i = 0; i < 7; ++i)
        EXPECT_NEAR(table.values[0][i] * 65535, published[i], 0.6 + 0.013 * published[i]) << i;
}

// Exact Fresnel term; the index falls below 1 in the lower half of the axis.
TEST(OpenPbrTable, of_dielectrics_agrees_with_quadrature) {
    TableSpec spec = preset("openpbr-dielectric", 6, 1e-4);
    set_model(spec, model_named("ggx"));
    const Table table = compute_table(device(), spec);
    const Axis& ior = spec.axes[2];
    EXPECT_NEAR(ior.value(0), 1 / 2.5, 1e-12);
    EXPECT_NEAR(ior.value(15), 1, 1e-12);
    EXPECT_NEAR(ior.value(16), 1, 1e-12);
    EXPECT_NEAR(ior.value(31), 2.5, 1e-12);
    for (const std::size_t z : {0U, 16U, 20U, 31U})
        for (std::size_t e = 0; e < 36; ++e) {
            const double mu = std::max(static_cast<double>(e % 6) / 5, 1e-4);
            const double alpha = std::pow(static_cast<double>(e / 6) / 5, 2);
            // Narrow lobes meet total reflection beyond the reference's reach.
            if (alpha > (ior.value(z) < 1 ? 0.3 : 0) && (ior.value(z) >= 1 || e % 6 > 0)) {
                EXPECT_NEAR(table.values[0][z * 36 + e],
                            1 - test::ggx_albedo(mu, alpha, ior.value(z)).weighted, 1.5e-4)
                    << z << " " << e;
            }
        }
}

// A mirror's average is that of Fresnel's term, whose slope is infinite where reflection is total.
TEST(OpenPbrTable, of_dielectrics_averages_total_reflection) {
    TableSpec spec = preset("openpbr-dielectric-average", 2, 1e-4);
    spec.axes[1].size = 4;
    const Table table = compute_table(device(), spec);
    const double ior = spec.axes[1].value(0), critical = std::sqrt(1 - ior * ior);
    double sum = critical * critical; // 2 integral of mu
    constexpr int parts = 20000;
    for (int i = 0; i < parts; ++i) {
        const double t = (i + 0.5) / parts, mu = critical + (1 - critical) * t * t;
        sum += 2 * mu * test::ggx_albedo(mu, 0, ior).weighted * (1 - critical) * 2 * t / parts;
    }
    EXPECT_NEAR(table.values[0][0], 1 - sum, 1e-4);
    EXPECT_LT(table.error, 2.5e-4);
}

TEST(GltfTable, holds_scale_and_bias) {
    constexpr std::size_t size = 8;
    for (const auto& [name, power] : {std::pair("gltf", 2.0), {"materialx", 1.0}}) {
        const Table table = compute_table(device(), preset(name, size, 1e-4));
        const double p = power;
        expect_entries(table, 0, 1e-4, [p](double x, double y) {
            const test::GgxAlbedo e =
                test::ggx_albedo((x + 0.5) / size, std::pow((y + 0.5) / size, p));
            return e.all - e.weighted;
        });
        expect_entries(table, 1, 1e-4, [p](double x, double y) {
            return test::ggx_albedo((x + 0.5) / size, std::pow((y + 0.5) / size, p)).weighted;
        });
    }
}

TEST(KullaContyTable, average_is_that_of_its_albedo) {
    const Table table = compute_table(device(), preset("kulla-conty-average", 5, 5e-5));
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_NEAR(table.values[0][i], test::average_over_cosine([&](double mu) {
                        return test::ggx_albedo(mu, (static_cast<double>(i) + 0.5) / 5).all;
                    }),
                    1e-4);
}

TEST(Table, takes_any_model_and_its_parameters) {
    for (const Model& model : catalogue()) {
        if (model.kind != Kind::Lobe)
            continue;
        TableSpec spec = preset("kulla-conty", 4, 1e-3);
        set_model(spec, model);
        const Table table = compute_table(device(), spec);
        for (const double value : table.values[0])
            EXPECT_TRUE(std::isfinite(value) && value >= 0) << model.name;
    }
    TableSpec spec = preset("kulla-conty", 4, 1e-4);
    set_model(spec, model_named("kurt"));
    set_parameter(spec, "alpha", 0.5);
    const Table table = compute_table(device(), spec);
    const Vector wo{std::sqrt(1 - 0.375 * 0.375), 0, 0.375};
    EXPECT_NEAR(table.values[0][8 + 1],
                test::reference_albedo("kurt", true, {1, 0.625, 0.5}, wo, 0.625), 1e-4);
    EXPECT_THROW(set_parameter(spec, "m", 0.5), UsageError);
    EXPECT_THROW(set_parameter(spec, "alpha", 3), UsageError);
    EXPECT_THROW(set_model(spec, model_named("lambert")), UsageError);
    // Infinite, not silently something.
    spec.axes[0].nodes = Nodes::Corners;
    EXPECT_THROW(compute_table(device(), spec), InputError);
}

TEST(TableSpecification, is_affine_in_f0) {
    const TableSpec spec = parse_table_spec(
        R"({"name": "t", "quantity": "albedo", "axes": [
             {"axis": "cos_theta", "size": 3, "nodes": "centres"},
             {"axis": "roughness", "size": 2, "nodes": "centres", "power": 2},
             {"axis": "f0", "size": 3}]})",
        "spec");
    const Table table = compute_table(device(), spec);
    ASSERT_EQ(table.values[0].size(), 18U);
    for (std::size_t e = 0; e < 6; ++e) {
        const test::GgxAlbedo expected =
            test::ggx_albedo((static_cast<double>(e % 3) + 0.5) / 3,
                             std::pow((static_cast<double>(e / 3) + 0.5) / 2, 2));
        EXPECT_NEAR(table.values[0][e], expected.weighted, 1e-4);
        EXPECT_NEAR(table.values[0][6 + e], (expected.weighted + expected.all) / 2, 1e-4);
        EXPECT_NEAR(table.values[0][12 + e], expected.all, 1e-4);
    }
}

// Kurt's own alpha beside the roughness m.
TEST(TableSpecification, has_axes_of_the_models_own_parameters) {
    const TableSpec spec = parse_table_spec(
        R"({"model": "kurt", "axes": [
             {"axis": "parameter:alpha", "size": 3, "range": [0, 0.8]},
             {"axis": "cos_theta", "size": 2, "nodes": "centres"},
             {"axis": "roughness", "size": 2, "nodes": "centres"},
             {"axis": "f0", "size": 2}]})",
        "spec");
    const Table table = compute_table(device(), spec);
    ASSERT_EQ(table.values[0].size(), 24U);
    AlbedoIntegrator integrator(device(), {&model_named("lambert"), {spec.model}, false}, 1);
    std::vector<AlbedoTask> tasks;
    for (const double m : {0.25, 0.75})
        for (const double mu : {0.25, 0.75})
            for (const double alpha : {0.0, 0.4, 0.8})
                tasks.push_back(
                    {{std::sqrt(1 - mu * mu), 0, mu}, {1, m, m, alpha}, spec.tolerance, 0});
    const std::vector<AlbedoValue> expected = integrator.integrate(tasks);
    for (std::size_t e = 0; e < 12; ++e) {
        EXPECT_NEAR(table.values[0][e], expected[e].weighted, 2e-4) << e;
        EXPECT_NEAR(table.values[0][12 + e], expected[e].all, 2e-4) << e;
    }
    const Vector wo{std::sqrt(1 - 0.0625), 0, 0.25};
    EXPECT_NEAR(table.values[0][12 + 1],
                test::reference_albedo("kurt", true, {1, 0.25, 0.4}, wo, 0.25), 1e-4);
    EXPECT_EQ(spec.axes[0].name(), "parameter:alpha");

    TableSpec other = spec;
    EXPECT_THROW(set_model(other, model_named("ggx")), UsageError);
    EXPECT_THROW(set_parameter(other, "alpha", 0.5), UsageError);
    const auto says = [](const std::string& axis, const std::string& rest,
                         const std::string& text) {
        const std::string message = test::complaint([&] {
            parse_table_spec(R"({"axes": [{"axis": "roughness", "size": 4}, )" + axis + "]" + rest +
                                 "}",
                             "spec");
        });
        EXPECT_NE(message.find(text), std::string::npos) << axis << ": " << message;
    };
    const std::string model = R"(, "model": "kurt")";
    says(R"({"axis": "parameter:alpha", "size": 3, "range": [0, 2.5]})", model, "range[1]: is 2.5");
    says(R"({"axis": "parameter:beta", "size": 3})", model, "parameter:alpha");
    says(R"({"axis": "parameter:m", "size": 3})", model, "parameter:alpha");
    says(R"({"axis": "parameter:f0", "size": 3})", model, "parameter:alpha");
    says(R"({"axis": "parameter:alpha", "size": 3})", R"(, "model": "ggx")", "it has none");
    says(R"({"axis": "parameter:alpha", "size": 3})", model + R"(, "parameters": {"alpha": 1})",
         "parameters.alpha");
}

TEST(TableSpecification, refuses_what_it_does_not_know) {
    const std::string axes =
        R"("axes": [{"axis": "cos_theta", "size": 4}, {"axis": "roughness", "size": 4}])";
    EXPECT_NO_THROW(parse_table_spec("{" + axes + "}", "spec"));
    for (
        const std::string& text : std::vector<std::string>{
            "",
            "[]",
            "{}",
            "{" + axes + R"(, "size": 3})",
            "{" + axes + R"(, "model": "none"})",
            "{" + axes + R"(, "model": "lambert"})",
            "{" + axes + R"(, "quantity": "x"})",
            "{" + axes + R"(, "f0": 2})",
            "{" + axes + R"(, "f0": 0.5, "f0": 0.5})",
            "{" + axes + R"(, "name": "1 2"})",
            "{" + axes + R"(, "parameters": {"b": 1}})",
            "{" + axes + R"(, "encoding": 3})",
            R"({"axes": [{"axis": "cos_theta", "size": 1}, {"axis": "roughness", "size": 4}]})",
            R"({"axes": [{"axis": "cos_theta", "size": 4}]})",
            R"({"axes": [{"axis": "roughness", "size": 4}, {"axis": "roughness", "size": 4}]})",
            R"({"axes": [{"axis": "roughness", "size": 4, "step": 1}]})",
            R"({"axes": [{"axis": "roughness", "size": 1e9}]})",
            R"({"axes": [{"axis": "roughness", "size": 2.5}]})",
            R"({"quantity": "scale-bias", "axes": [{"axis": "roughness", "size": 4}, {"axis": "ior", "size": 4}]})",
            R"({"axes": [{"axis": "roughness", "size": 4}, {"axis": "ior", "size": 2, "mapping": "openpbr"}]})",
            R"({"axes": [{"axis": "roughness", "size": 4}, {"axis": "ior", "size": 5, "mapping": "openpbr"}]})",
            R"({"axes": [{"axis": "roughness", "size": 4096}, {"axis": "cos_theta", "size": 4096}]})",
            std::string(5000, '[')})
        EXPECT_THROW(parse_table_spec(text, "spec"), InputError) << text.substr(0, 100);
    for (const char* tolerance : {"0", "-1", "1e-12", "2"})
        EXPECT_THROW(parse_table_spec("{" + axes + R"(, "tolerance": )" + tolerance + "}", "spec"),
                     InputError)
            << tolerance;
}

TEST(TableFile, holds_the_entries_and_where_they_come_from) {
    const TemporaryFolder folder;
    Table table = compute_table(device(), preset("filament", 4, 1e-3));
    write_table(table, folder / "t.exr");
    const Image image = read_exr(folder / "t.exr");
    EXPECT_EQ(image.width, 4U);
    EXPECT_EQ(image.height, 4U);
    ASSERT_NE(image.plane("R"), nullptr);
    for (std::size_t e = 0; e < 16; ++e) {
        EXPECT_NEAR((*image.plane("R"))[e], table.values[0][e], 1e-3);
        EXPECT_NEAR((*image.plane("G"))[e], table.values[1][e], 1e-3);
        EXPECT_EQ((*image.plane("B"))[e], 0);
    }
    for (const char* name : {"table", "quantity", "axis_cos_theta", "axis_roughness", "order",
                             "encoding", "model", "tolerance", "software"})
        EXPECT_EQ(image.metadata.count(name), 1U) << name;

    // cmgen's text: rows bottom up, red and green of a pixel as halves.
    write_table(table, folder / "t.h");
    const std::string text = test::read_file(folder / "t.h");
    EXPECT_NE(text.find("const uint16_t DFG_LUT[] = {"), std::string::npos);
    EXPECT_NE(text.find("// axis_roughness: "), std::string::npos);
    const auto bits = [&](std::size_t channel, std::size_t e) {
        return fmt::format("0x{:04x}",
                           Imath::half(static_cast<float>(table.values[channel][e])).bits());
    };
    EXPECT_EQ(text.substr(text.find("{\n") + 2).rfind("    " + bits(0, 12) + ", " + bits(1, 12), 0),
              0U);

    write_table(table, folder / "t.npy");
    const std::string npy = test::read_file(folder / "t.npy");
    EXPECT_NE(npy.find("'descr': '<f2', 'fortran_order': False, 'shape': (4, 4, 2)"),
              std::string::npos);
    EXPECT_EQ(npy.size() % 64, 0U);
    std::uint16_t first = 0;
    std::memcpy(&first, npy.data() + npy.size() - 64, sizeof first);
    EXPECT_EQ(first, Imath::half(static_cast<float>(table.values[0][0])).bits());
    EXPECT_EQ(nlohmann::json::parse(test::read_file(folder / "t.npy.json"))["shape"],
              nlohmann::json({4, 4, 2}));

    write_table(table, folder / "t.csv");
    std::istringstream csv(test::read_file(folder / "t.csv"));
    std::string line;
    while (std::getline(csv, line) && line[0] == '#') {
    }
    EXPECT_EQ(line, "cos_theta,roughness,R,G");
    std::getline(csv, line);
    EXPECT_EQ(line.rfind("0.125,1,", 0), 0U);
}

TEST(TableFile, of_open_pbr_is_a_fragment_and_of_cycles_an_array) {
    const TemporaryFolder folder;
    const Table openpbr = compute_table(device(), preset("openpbr", 4, 1e-3));
    write_table(openpbr, folder / "o.h");
    std::istringstream lines(test::read_file(folder / "o.h"));
    std::string line;
    std::vector<long> numbers;
    while (std::getline(lines, line)) {
        if (line.rfind("//", 0) == 0)
            continue;
        std::istringstream fields(line);
        for (std::string field; std::getline(fields, field, ',');)
            numbers.push_back(std::stol(field));
    }
    ASSERT_EQ(numbers.size(), 16U);
    for (std::size_t e = 0; e < 16; ++e)
        EXPECT_NEAR(static_cast<double>(numbers[e]), 65535 * std::max(0.0, openpbr.values[0][e]),
                    0.51);

    write_table(compute_table(device(), preset("cycles", 4, 1e-3)), folder / "c.h");
    const std::string text = test::read_file(folder / "c.h");
    EXPECT_NE(text.find("static const float table_ggx_E[16] = {\n  "), std::string::npos);
    EXPECT_EQ(text.substr(text.size() - 5), "f\n};\n");
    EXPECT_THROW(write_table(openpbr, folder / "o.txt"), UsageError);
}

// Kurt with alpha above 0 reflects more than it receives.
TEST(TableFile, of_unorm16_refuses_what_it_cannot_hold) {
    const TemporaryFolder folder;
    TableSpec spec = preset("kulla-conty", 4, 1e-4);
    set_model(spec, model_named("kurt"));
    set_parameter(spec, "alpha", 0.5);
    spec.encoding = Encoding::Unorm16;
    const Table table = compute_table(device(), spec);
    const std::vector<double>& values = table.values[0];
    const auto above = static_cast<std::size_t>(
        std::count_if(values.begin(), values.end(), [](double v) { return v > 1.001; }));
    const double largest = *std::max_element(values.begin(), values.end());
    ASSERT_GT(above, 0U);
    EXPECT_EQ(table.above_one.count, above);
    EXPECT_EQ(table.above_one.largest, largest);
    for (const char* name : {"t.exr", "t.h", "t.npy", "t.csv"}) {
        const std::string message = test::complaint([&] { write_table(table, folder / name); });
        EXPECT_NE(message.find(fmt::format("{} of 16 values are outside", above)),
                  std::string::npos)
            << message;
        EXPECT_NE(message.find(fmt::format("{:.6g}", largest)), std::string::npos) << message;
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    EXPECT_EQ(write_table(table, folder / "t.h", true), above);
    EXPECT_NE(test::read_file(folder / "t.h").find("65535"), std::string::npos);

    const std::vector<std::string> command{"table", "kulla-conty",   "-m",     "kurt",
                                           "--fix", "alpha=0.5",     "--size", "4",
                                           "-o",    folder / "u.npy"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), command.begin(), command.end());
        return run_program(more);
    };
    EXPECT_EQ(with({"--encoding", "unorm16"}).status, 1);
    EXPECT_FALSE(std::filesystem::exists(folder / "u.npy"));
    const auto clamped = with({"--encoding", "unorm16", "--clamp"});
    EXPECT_EQ(clamped.status, 0) << clamped.err;
    EXPECT_NE(clamped.err.find(fmt::format("{} of 16 values", above)), std::string::npos)
        << clamped.err;
    EXPECT_EQ(with({"--clamp"}).status, 2);
    // Said whatever the encoding.
    const auto whole = with({});
    EXPECT_EQ(whole.status, 0) << whole.err;
    EXPECT_NE(whole.err.find(fmt::format("{} of 16 albedos of kurt are above 1, the largest {:.4g}",
                                         above, largest)),
              std::string::npos)
        << whole.err;
}

// What .exr viewers show black.
TEST(TableCommand, writes_a_preview) {
    const TemporaryFolder folder;
    const auto made = run_program({"table", "filament", "--size", "8", "--tolerance", "1e-3", "-o",
                                   folder / "t.csv", "--preview", folder / "t.png"});
    ASSERT_EQ(made.status, 0) << made.err;
    EXPECT_NE(made.err.find("R (white "), std::string::npos) << made.err;
    const Image picture = read_png(folder / "t.png");
    EXPECT_EQ(picture.width, 2U * 256 + 8);
    EXPECT_EQ(picture.height, 256U);
    const Table table = compute_table(device(), preset("filament", 8, 1e-3));
    for (const std::size_t v : {0U, 1U}) {
        const std::vector<double>& values = table.values[v];
        const double most = *std::max_element(values.begin(), values.end());
        for (std::size_t e = 0; e < 64; ++e)
            EXPECT_NEAR(
                picture.planes[0][(e / 8 * 32 + 16) * picture.width + v * 264 + e % 8 * 32 + 16],
                values[e] / most, 0.01)
                << e;
    }
}

// Before any work: no device of that name is looked for.
TEST(TableCommand, looks_at_endings_first) {
    const TemporaryFolder folder;
    test::write_file(folder / "s.json", R"({"distribution": "gaussian", "sigma": 0.3})");
    const std::string spec = folder / "s.json", bad = folder / "x.txt";
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"table", "cycles", "-o", bad},
          {"table", "cycles", "-o", folder / "x.h", "--preview", bad},
          {"generate", spec, "-o", bad},
          {"generate", spec, "-o", folder / "x.exr", "--preview", bad},
          {"generate", "--from", folder / "none.csv", "-o", bad},
          {"albedo", folder / "none.json", "-o", bad}}) {
        std::vector<std::string> arguments = command;
        arguments.insert(arguments.end(), {"--device", "no such device"});
        const auto run = run_program(arguments);
        EXPECT_EQ(run.status, 2) << command[0];
        EXPECT_NE(run.err.find("x.txt: unknown ending"), std::string::npos) << run.err;
    }
}

TEST(TableFile, is_not_written_where_a_value_is_not_finite) {
    const TemporaryFolder folder;
    Table table = compute_table(device(), preset("kulla-conty", 4, 1e-3));
    for (const auto& [value, encoding] : {std::pair(std::nan(""), Encoding::Float),
                                          {1e39, Encoding::Float},
                                          {7e4, Encoding::Half}}) {
        table.values[0][5] = value;
        table.spec.encoding = encoding;
        for (const char* name : {"t.exr", "t.h", "t.npy", "t.csv"})
            EXPECT_THROW(write_table(table, folder / name), InputError) << name << value;
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(TableCommand, writes_tables_and_refuses_bad_command_lines) {
    const TemporaryFolder folder;
    const std::string out = folder / "t.csv";
    const auto list = run_program({"table", "--list"});
    EXPECT_EQ(list.status, 0);
    for (const Preset& one : presets())
        EXPECT_NE(list.out.find(one.name), std::string::npos);
    const auto made = run_program({"table", "kulla-conty", "-m", "kurt", "--fix", "alpha=0",
                                   "--size", "4", "--tolerance", "1e-3", "-o", out});
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_NE(test::read_file(out).find("# model: kurt, m = roughness, alpha = 0"),
              std::string::npos);
    test::write_file(folder / "bad.json", R"({"axis": []})");
    const std::vector<std::pair<int, std::vector<std::string>>> cases = {
        {2, {"none"}},
        {2, {"cycles", "-m", "none"}},
        {2, {"cycles", "-m", "lambert"}},
        {2, {"cycles", "--size", "1"}},
        {2, {"cycles", "--tolerance", "0"}},
        {2, {"cycles", "--tolerance", "1e-9"}},
        {2, {"cycles", "--encoding", "double"}},
        {2, {"cycles", "--fix", "a=1"}},
        {1, {folder / "bad.json"}},
        {1, {folder / "none.json"}},
    };
    for (const auto& [status, extra] : cases) {
        std::vector<std::string> arguments{"table", "-o", folder / "x.exr"};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        const auto run = run_program(arguments);
        EXPECT_EQ(run.status, status) << extra.back() << run.err;
        EXPECT_FALSE(run.err.empty());
    }
    EXPECT_EQ(run_program({"table", "cycles", "-o", folder / "x.txt"}).status, 2);
    EXPECT_EQ(run_program({"table", "cycles"}).status, 2);
    EXPECT_FALSE(std::filesystem::exists(folder / "x.exr"));
}

} // namespace
} // namespace brdfit

#include "host/embedded.hpp"
#include "host/error.hpp"
#include "host/files/json.hpp"
#include "host/model/material.hpp"
#include "tests/support/examples.hpp"
#include "tests/support/support.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>

namespace brdfit {

namespace {

using Json = nlohmann::ordered_json;

Json example() {
    return Json::parse(test::material_example);
}

Material parse(const Json& json) {
    return parse_material(json.dump(), "paint.json");
}

/// What the parser says of a text; empty when it is content.
std::string complaint(const std::string& text) {
    return test::complaint([&] { parse_material(text, "paint.json"); });
}

/// What the parser says of the example after a change.
std::string complaint(const std::function<void(Json&)>& change) {
    Json json = example();
    change(json);
    return complaint(json.dump());
}

class MaterialFile : public testing::Test {
  protected:
    const test::TemporaryFolder folder_;
    const std::string path = folder_ / "material.json";
};

} // namespace

TEST(Material, has_every_part_of_its_file) {
    const Material material = parse(example());
    EXPECT_EQ(material.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(material.diffuse->name, "lambert");
    EXPECT_EQ(material.kd, (std::vector<double>{0.1, 0.2, 0.3}));
    ASSERT_EQ(material.lobes.size(), 2u);
    EXPECT_EQ(material.lobes[0].model->name, "kurt");
    EXPECT_FALSE(material.lobes[0].isotropic);
    EXPECT_EQ(material.lobes[0].theta, (std::vector<double>{0.05, 0.2, 0.3, 0.1}));
    EXPECT_EQ(material.lobes[0].ks, (std::vector<double>{0.5, 0.5, 0.5}));
    EXPECT_TRUE(material.lobes[1].isotropic);
    EXPECT_EQ(material.lobes[1].theta, (std::vector<double>{0.2}));
    EXPECT_EQ(material.fit, example()["fit"]);
}

TEST(Material, may_have_no_lobe_and_no_fit) {
    Json json = example();
    json["lobes"] = Json::array();
    json.erase("fit");
    const Material material = parse(json);
    EXPECT_TRUE(material.lobes.empty());
    EXPECT_TRUE(material.fit.is_null());
    EXPECT_EQ(to_json(material), json);
}

TEST(Material, order_of_keys_is_free) {
    const Material material = parse_material(
        R"({"lobes": [{"m": 0.2, "ks": [1], "model": "ward"}], "diffuse": {"kd": [0], "model": "lambert"},
            "channels": ["Y"], "brdfit": 1})",
        "paint.json");
    EXPECT_EQ(material.lobes[0].theta, (std::vector<double>{0.2}));
}

TEST(Material, repeats_the_roughness_of_isotropic_lobes) {
    Json json = example();
    json["lobes"] =
        Json::parse(R"([{"model": "kurt", "ks": [1, 1, 1], "f0": 0.5, "m": 0.25, "alpha": 0.1},
        {"model": "ashikhmin-shirley", "ks": [1, 1, 1], "f0": 0.5, "n": 10},
        {"model": "cook-torrance", "ks": [1, 1, 1], "f0": 0.5, "m": 0.25}])");
    const Material material = parse(json);
    EXPECT_EQ(material.lobes[0].anisotropic_theta(), (std::vector<double>{0.5, 0.25, 0.25, 0.1}));
    EXPECT_EQ(material.lobes[1].anisotropic_theta(), (std::vector<double>{0.5, 10, 10}));
    EXPECT_EQ(material.lobes[2].anisotropic_theta(), (std::vector<double>{0.5, 0.25}));
}

TEST(Material, is_isotropic_where_roughnesses_are_equal) {
    Json json = example();
    EXPECT_FALSE(parse(json).isotropic());
    json["lobes"][0]["my"] = json["lobes"][0]["mx"];
    EXPECT_TRUE(parse(json).isotropic());
    json["lobes"] = Json::array();
    EXPECT_TRUE(parse(json).isotropic());
}

// Every lobe model, in both forms, with each parameter at its bounds and just beyond them.
TEST(Material, takes_every_lobe_model_within_its_bounds) {
    for (const Model& model : catalogue()) {
        if (model.kind != Kind::Lobe)
            continue;
        for (const bool isotropic : {true, false}) {
            Json lobe = {{"model", model.name}, {"ks", {1, 1, 1}}};
            for (const Parameter& p : model.parameters(isotropic))
                lobe[p.name] = p.start;
            Json json = example();
            json["lobes"] = {lobe};
            EXPECT_EQ(to_json(parse(json)), json) << model.name;
            for (const Parameter& p : model.parameters(isotropic)) {
                for (const double good : {p.lower, p.upper}) {
                    json["lobes"][0][p.name] = good;
                    EXPECT_EQ(complaint(json.dump()), "");
                }
                for (const double bad : {p.lower - 1e-9, p.upper * (1 + 1e-9)}) {
                    json["lobes"][0][p.name] = bad;
                    EXPECT_NE(complaint(json.dump())
                                  .find(fmt::format("paint.json: lobes[0].{}: is ", p.name)),
                              std::string::npos);
                }
                json["lobes"][0].erase(p.name);
                EXPECT_NE(complaint(json.dump()).find("is missing"), std::string::npos)
                    << model.name << " without " << p.name;
                json["lobes"] = {lobe};
            }
        }
    }
}

TEST(Material, demo_materials_parse) {
    int count = 0;
    for (const EmbeddedFile* file = embedded_demo; file->name != nullptr; ++file, ++count) {
        const Material material = parse_material(file->text, file->name);
        EXPECT_TRUE(material.isotropic()) << file->name;
        EXPECT_TRUE(material.fit.is_null()) << file->name;
        EXPECT_GT(material.lobes.size(), 1u) << file->name;
    }
    EXPECT_EQ(count, 3);
}

TEST_F(MaterialFile, survives_writing_and_reading) {
    Json json = example();
    // Numbers that need all their digits, or few.
    json["diffuse"]["kd"] = {0.1, 1.0 / 3, 1e-300};
    json["lobes"][0]["mx"] = 0.1 + 0.2;
    json["lobes"][0]["ks"] = {5e-324, 3e38, 12345678.9};
    write_material(parse(json), path);
    EXPECT_EQ(to_json(read_material(path)), json);
    const std::string first = test::read_file(path);
    write_material(read_material(path), path);
    EXPECT_EQ(test::read_file(path), first);
    EXPECT_NE(first.find("0.30000000000000004"), std::string::npos);
}

TEST_F(MaterialFile, is_laid_out_for_people) {
    Json json = example();
    json.erase("fit");
    write_material(parse(json), path);
    EXPECT_EQ(test::read_file(path), R"({
  "brdfit": 1,
  "channels": ["R", "G", "B"],
  "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
  "lobes": [
    {"model": "kurt", "ks": [0.5, 0.5, 0.5], "f0": 0.05, "mx": 0.2, "my": 0.3, "alpha": 0.1},
    {"model": "ward", "ks": [0.25, 0.0, 1.0], "m": 0.2}
  ]
}
)");
}

TEST_F(MaterialFile, keeps_names_in_any_script) {
    Json json = example();
    json["channels"] = {"rød", "400 nm", "藍"};
    write_material(parse(json), path);
    EXPECT_EQ(to_json(read_material(path)), json);
}

TEST_F(MaterialFile, must_exist_and_not_be_huge) {
    EXPECT_THROW(read_material(path), InputError);
    test::write_file(path, "{}");
    std::filesystem::resize_file(path, std::uintmax_t{17} << 20);
    EXPECT_THROW(read_material(path), InputError);
}

TEST(BadMaterial, is_named_by_key_and_expectation) {
    using Change = std::function<void(Json&)>;
    const struct {
        Change change;
        const char* message;
    } cases[] = {
        {[](Json& j) { j["lobes"][1]["m"] = -0.2; },
         "paint.json: lobes[1].m: is -0.2; expected a number in [0.001, 10]"},
        {[](Json& j) { j["lobes"][1]["m"] = "rough"; },
         "paint.json: lobes[1].m: is \"rough\"; expected a number in [0.001, 10]"},
        {[](Json& j) { j["lobes"][1]["m"] = nullptr; },
         "paint.json: lobes[1].m: is null; expected a number in [0.001, 10]"},
        {[](Json& j) { j["lobes"][1]["m"] = true; },
         "paint.json: lobes[1].m: is true; expected a number in [0.001, 10]"},
        {[](Json& j) { j["lobes"][1]["m"] = {0.1}; },
         "paint.json: lobes[1].m: is an array; expected a number in [0.001, 10]"},
        {[](Json& j) { j["lobes"][0]["f0"] = 1.5; },
         "paint.json: lobes[0].f0: is 1.5; expected a number in [0, 1]"},
        {[](Json& j) { j["lobes"][0].erase("f0"); },
         "paint.json: lobes[0].f0: is missing; expected a number in [0, 1]"},
        {[](Json& j) { j["lobes"][0].erase("my"); },
         "paint.json: lobes[0].my: is missing; expected a number in [0.001, 10]"},
        {[](Json& j) { j["lobes"][1].erase("m"); },
         "paint.json: lobes[1].m: is missing; expected either m or mx and my"},
        {[](Json& j) { j["lobes"][0]["m"] = 0.2; },
         "paint.json: lobes[0].mx: stands beside m; expected either m or mx and my"},
        {[](Json& j) { j["lobes"][1]["my"] = 0.2; },
         "paint.json: lobes[1].my: stands beside m; expected either m or mx and my"},
        {[](Json& j) { j["lobes"][1]["rough"] = 0.2; },
         "paint.json: lobes[1].rough: is an unknown key; expected one of model, ks, m, mx, my"},
        {[](Json& j) { j["lobes"][1]["a.b c"] = 0.2; },
         "paint.json: lobes[1].\"a.b c\": is an unknown key; expected one of model, ks, m, mx, my"},
        {[](Json& j) { j["lobes"][0]["model"] = "lambert"; },
         "paint.json: lobes[0].model: is \"lambert\"; expected a lobe model: kurt"},
        {[](Json& j) { j["lobes"][0]["model"] = "kurt-coupled"; },
         "paint.json: lobes[0].model: is \"kurt-coupled\"; expected a lobe model: kurt"},
        {[](Json& j) { j["lobes"][0]["model"] = "Kurt"; },
         "paint.json: lobes[0].model: is \"Kurt\"; expected a lobe model: kurt"},
        {[](Json& j) { j["lobes"][0]["model"] = 3; },
         "paint.json: lobes[0].model: is 3; expected a lobe model: kurt"},
        {[](Json& j) { j["lobes"][0].erase("model"); },
         "paint.json: lobes[0].model: is missing; expected a lobe model: kurt"},
        {[](Json& j) { j["lobes"][0].erase("ks"); },
         "paint.json: lobes[0].ks: is missing; expected an array of 3 numbers, one a channel"},
        {[](Json& j) {
             j["lobes"][0]["ks"] = {1, 1};
         },
         "paint.json: lobes[0].ks: has 2 values; expected an array of 3 numbers, one a channel"},
        {[](Json& j) { j["lobes"][0]["ks"] = 1; },
         "paint.json: lobes[0].ks: is 1; expected an array of 3 numbers, one a channel"},
        {[](Json& j) { j["lobes"][0]["ks"][2] = -1; },
         "paint.json: lobes[0].ks[2]: is -1; expected a number in [0, 3.40282e+38]"},
        {[](Json& j) { j["lobes"][0]["ks"][0] = 1e39; },
         "paint.json: lobes[0].ks[0]: is 1e+39; expected a number in [0, 3.40282e+38]"},
        {[](Json& j) { j["lobes"][1] = 5; },
         "paint.json: lobes[1]: is 5; expected an object that describes a lobe"},
        {[](Json& j) { j["lobes"] = Json::object(); },
         "paint.json: lobes: is an object; expected an array of 0 to 4 lobes"},
        {[](Json& j) { j.erase("lobes"); },
         "paint.json: lobes: is missing; expected an array of 0 to 4 lobes"},
        {[](Json& j) { j["lobes"] = Json(5, j["lobes"][1]); },
         "paint.json: lobes: has 5 lobes; expected at most 4"},
        {[](Json& j) { j["diffuse"]["kd"] = {0.1}; },
         "paint.json: diffuse.kd: has 1 values; expected an array of 3 numbers, one a channel"},
        {[](Json& j) { j["diffuse"]["kd"][1] = "x"; },
         "paint.json: diffuse.kd[1]: is \"x\"; expected a number in [0, 3.40282e+38]"},
        {[](Json& j) { j["diffuse"]["metal"] = true; },
         "paint.json: diffuse.metal: is an unknown key; expected one of model, kd"},
        {[](Json& j) { j["diffuse"]["model"] = "ward"; },
         "paint.json: diffuse.model: is \"ward\"; expected a diffuse model: lambert"},
        {[](Json& j) { j["diffuse"] = "lambert"; },
         "paint.json: diffuse: is \"lambert\"; expected an object with model and kd"},
        {[](Json& j) { j.erase("diffuse"); },
         "paint.json: diffuse: is missing; expected an object with model and kd"},
        {[](Json& j) {
             j["diffuse"]["model"] = "kurt-coupled";
             std::swap(j["lobes"][0], j["lobes"][1]);
         },
         "paint.json: diffuse.model: is \"kurt-coupled\"; expected a diffuse model that goes with "
         "ward; this one needs a first lobe of kurt"},
        {[](Json& j) {
             j["diffuse"]["model"] = "kurt-coupled";
             j["lobes"] = Json::array();
         },
         "paint.json: diffuse.model: is \"kurt-coupled\"; expected a diffuse model that goes with "
         "no lobe; this one needs a first lobe of kurt"},
        {[](Json& j) { j["channels"] = Json::array(); },
         "paint.json: channels: has 0 names; expected 1 to 4096"},
        {[](Json& j) { j["channels"] = Json(5000, "R"); },
         "paint.json: channels: has 5000 names; expected 1 to 4096"},
        {[](Json& j) { j["channels"] = "RGB"; },
         "paint.json: channels: is \"RGB\"; expected an array of channel names"},
        {[](Json& j) { j.erase("channels"); },
         "paint.json: channels: is missing; expected an array of channel names"},
        {[](Json& j) { j["channels"][2] = "G"; },
         "paint.json: channels[2]: is \"G\"; expected a name no other channel has"},
        {[](Json& j) { j["channels"][0] = 1; },
         "paint.json: channels[0]: is 1; expected a channel's name without commas"},
        {[](Json& j) { j["channels"][0] = ""; },
         "paint.json: channels[0]: is \"\"; expected a channel's name without commas"},
        {[](Json& j) { j["channels"][0] = "a,b"; },
         "paint.json: channels[0]: is \"a,b\"; expected a channel's name without commas"},
        {[](Json& j) { j["channels"][0] = "a\nb"; },
         "paint.json: channels[0]: is \"a\\nb\"; expected a channel's name without commas"},
        {[](Json& j) { j["brdfit"] = 2; },
         "paint.json: brdfit: is 2; expected 1, the version of the material format"},
        {[](Json& j) { j["brdfit"] = true; },
         "paint.json: brdfit: is true; expected 1, the version of the material format"},
        {[](Json& j) { j.erase("brdfit"); },
         "paint.json: brdfit: is missing; expected 1, the version of the material format"},
        {[](Json& j) { j["name"] = "paint"; },
         "paint.json: name: is an unknown key; expected one of brdfit, channels, diffuse, lobes, "
         "fit"},
        {[](Json& j) { j["fit"] = "good"; }, "paint.json: fit: is \"good\"; expected an object"},
        {[](Json& j) { j["fit"] = nullptr; }, "paint.json: fit: is null; expected an object"},
        {[](Json& j) { j = 3; }, "paint.json: is 3; expected an object that describes a material"},
        {[](Json& j) { j = Json::array(); },
         "paint.json: is an array; expected an object that describes a material"},
    };
    for (const auto& bad : cases)
        EXPECT_EQ(complaint(bad.change).substr(0, std::string(bad.message).size()), bad.message);
}

TEST(BadMaterial, repeats_no_key) {
    EXPECT_EQ(complaint(R"({"brdfit": 1, "brdfit": 1})"),
              "paint.json: brdfit: is given twice; expected once");
    EXPECT_EQ(
        complaint(
            R"({"brdfit": 1, "lobes": [{"f0": [[1], {}]}, {"m": 1, "ks": {"m": 0}, "m": 1}]})"),
        "paint.json: lobes[1].m: is given twice; expected once");
    EXPECT_EQ(complaint(R"({"fit": {"error": {"l2": 0, "l2": 0}}})"),
              "paint.json: fit.error.l2: is given twice; expected once");
}

TEST(BadMaterial, is_no_json) {
    for (const std::string text :
         {"", " ", "{", "[1,", "{\"brdfit\": NaN}", "{\"brdfit\": 1e999}", "{\"brdfit\": 1} x",
          "{\"a\": \"\xff\"}", "{'brdfit': 1}", "\x89PNG\r\n"})
        EXPECT_EQ(complaint(text).rfind("paint.json: is no JSON: ", 0), 0u) << complaint(text);
    EXPECT_EQ(complaint(std::string(1000, '\0')).rfind("paint.json: is no JSON: ", 0), 0u);
}

// Neither the parser nor what copies, prints or frees its result may run out of stack.
TEST(BadMaterial, is_not_nested_deeply) {
    constexpr std::size_t depth = 1000000;
    std::string objects;
    for (std::size_t i = 0; i < depth; ++i)
        objects += R"({"a":)";
    for (const std::string& text :
         {std::string(depth, '['), std::string(depth, '[') + std::string(depth, ']'), objects,
          R"({"fit": )" + objects})
        EXPECT_EQ(complaint(text), "paint.json: is nested too deeply; expected at most 32 levels");
}

TEST(BadMaterial, has_no_objects_of_more_keys_than_are_found_quickly) {
    const auto with_keys = [](std::size_t count) {
        Json json = example();
        std::string fit;
        for (std::size_t i = 0; i < count; ++i)
            fit += fmt::format("{}\"k{}\": 0", i == 0 ? "" : ", ", i);
        json["fit"] = "HERE";
        std::string text = json.dump();
        return text.replace(text.find("\"HERE\""), 6, "{" + fit + "}");
    };
    EXPECT_EQ(complaint(with_keys(max_json_keys)), "");
    EXPECT_NE(complaint(with_keys(max_json_keys + 1))
                  .find(fmt::format("an object of more than {} keys", max_json_keys)),
              std::string::npos)
        << complaint(with_keys(max_json_keys + 1));
}

TEST(BadMaterial, does_not_flood_the_message) {
    Json json = example();
    json["lobes"][0]["model"] = std::string(100000, 'x');
    EXPECT_LT(complaint(json.dump()).size(), 400u);
    json = example();
    json[std::string(100000, 'x')] = 1;
    EXPECT_LT(complaint(json.dump()).size(), 400u);
    EXPECT_LT(complaint("{\"a\": " + std::string(100000, 'x')).size(), 400u);
    EXPECT_LT(complaint("{\"a\": \"" + std::string(100000, 'x')).size(), 400u);
}

// Any shortening of a good file is a bad one, and says so.
TEST(BadMaterial, is_cut_off) {
    const std::string text = example().dump(1);
    for (std::size_t length = 0; length < text.size(); ++length)
        EXPECT_NE(complaint(text.substr(0, length)), "") << length;
}

} // namespace brdfit

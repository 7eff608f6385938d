// brdfit tune: what it keeps, and when that is used.

#include "host/device/kernels.hpp"
#include "host/device/probe.hpp"
#include "host/device/tuning.hpp"
#include "host/model/structure.hpp"
#include "tests/support/support.hpp"

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

namespace brdfit::test {

namespace {

// What device 0 has where nothing is kept.
Form form_without_tuning() {
    const Variable none("BRDFIT_TUNING", "");
    return open_device("0").form;
}

/// A tuning file of its own for every test.
class Tune : public testing::Test {
  protected:
    nlohmann::json entry() const { return nlohmann::json::parse(read_file(path_))["tuning"][0]; }
    void change(const std::string& key, const nlohmann::json& value) const {
        nlohmann::json changed = entry();
        changed[key] = value;
        write_file(path_, nlohmann::json{{"tuning", {changed}}}.dump());
    }

    TemporaryFolder folder_;
    const std::string path_ = folder_ / "new/folder/tuning.json";
    const Variable tuning_{"BRDFIT_TUNING", path_.c_str()};
    const Device untuned_ = list_devices().at(0);
    const Form chosen_ = form_without_tuning();
    // Unlike any shipped form, and possible everywhere.
    const Form other_{2, 1, 512, 3};
};

} // namespace

TEST_F(Tune, keeps_the_best_form_and_uses_it) {
    const Outcome outcome =
        run_program({"tune", "--device", "0", "--samples", "3000", "--forms", "2"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("shipped form: "), std::string::npos) << outcome.out;
    const auto kept = entry();
    EXPECT_EQ(kept.at("device"), untuned_.name);
    EXPECT_EQ(kept.at("driver"), untuned_.driver);
    EXPECT_EQ(kept.at("kernels"), kernel_hash());
    const Form used = open_device("0").form;
    EXPECT_EQ(used.vector_width, kept.at("vector_width"));
    EXPECT_EQ(used.candidates, kept.at("candidates"));
}

TEST_F(Tune, a_kept_form_is_used_until_something_changes) {
    store_tuned_form(untuned_, {4, 1, 1024, 1});
    store_tuned_form(untuned_, other_); // in place of the first
    EXPECT_EQ(nlohmann::json::parse(read_file(path_))["tuning"].size(), 1);
    EXPECT_EQ(open_device("0").form, other_);
    for (const char* key : {"device", "platform", "driver", "kernels"}) {
        change(key, "another");
        EXPECT_EQ(open_device("0").form, chosen_) << key;
        std::filesystem::remove(path_); // which may keep what the device was asked
        store_tuned_form(untuned_, other_);
        EXPECT_EQ(open_device("0").form, other_) << key;
    }
    const Variable form("BRDFIT_FORM", "8,1,1024");
    EXPECT_EQ(open_device("0").form.vector_width, 8);
}

TEST_F(Tune, a_form_is_kept_with_the_reason_for_it) {
    EXPECT_NE(open_device("0").form_reason, "");
    store_tuned_form(untuned_, other_);
    EXPECT_EQ(open_device("0").form_reason, "brdfit tune found it");
    store_tuned_form(untuned_, other_, "a probe");
    EXPECT_EQ(open_device("0").form_reason, "a probe");
    change("reason", 1); // not what we write
    EXPECT_EQ(open_device("0").form_reason, "brdfit tune found it");
}

// Where the driver is asked what it does, the answer is kept, and right whatever the device claims.
TEST_F(Tune, a_cpu_that_is_not_known_is_asked_once) {
    Device asked = open_device("0");
    asked.cpu = true;
    asked.platform = "another";
    choose_shipped_form(asked);
    EXPECT_NE(asked.form_reason.find("G exp/s"), std::string::npos) << asked.form_reason;
    EXPECT_EQ(asked.form, shipped_form(asked));
    const std::optional<TunedForm> kept = tuned_form(asked);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->form, asked.form);
    EXPECT_EQ(kept->reason, asked.form_reason);
    asked.max_allocation = 0; // nothing runs there
    choose_shipped_form(asked);
    EXPECT_EQ(asked.form.vector_width, 1);
    EXPECT_NE(asked.form_reason.find("the probe failed: "), std::string::npos);
}

TEST_F(Tune, forms_that_cannot_run_and_broken_files_are_ignored) {
    store_tuned_form(untuned_, other_);
    for (const auto& [key, value] :
         std::vector<std::pair<std::string, nlohmann::json>>{{"vector_width", 3},
                                                             {"vector_width", 32},
                                                             {"local_size", 0},
                                                             {"local_size", 1 << 20},
                                                             {"block", 7},
                                                             {"block", -512},
                                                             {"candidates", 0},
                                                             {"candidates", 1000},
                                                             {"block", "many"}}) {
        const nlohmann::json before = entry()[key];
        change(key, value);
        EXPECT_EQ(open_device("0").form, chosen_) << key << " " << value;
        change(key, before);
    }
    const std::string nested = "{\"tuning\": " + std::string(500000, '[');
    for (const std::string& text :
         {std::string(), std::string("{"), std::string("[]"), std::string("{\"tuning\": 1}"),
          std::string("{\"tuning\": [1, {}, null]}"), nested,
          nested + std::string(500000, ']') + "}", std::string(500000, '[')}) {
        write_file(path_, text);
        EXPECT_EQ(open_device("0").form, chosen_) << text.substr(0, 40);
    }
}

// Errors that root meets too.
TEST_F(Tune, a_place_that_cannot_be_read_is_said_once_and_the_shipped_form_used) {
    std::filesystem::create_symlink("loop", folder_ / "loop");
    write_file(folder_ / "file", "");
    write_file(folder_ / "m.json", R"({"brdfit": 1, "channels": ["R"], "lobes": [],
        "diffuse": {"model": "lambert", "kd": [0.1]}})");
    const std::vector<std::string> command{"synth", folder_ / "m.json", folder_ / "v.csv",
                                           "--directions", "10"};
    const std::string loop = folder_ / "loop", longer(5000, 'x');
    for (const std::string& place :
         {"BRDFIT_TUNING=" + loop, "BRDFIT_TUNING=" + loop + "/tuning.json",
          "BRDFIT_TUNING=" + longer, "BRDFIT_TUNING=" + folder_.path().string()}) {
        const Outcome outcome = run_program(command, {place});
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.err.find("warning"), outcome.err.rfind("warning")) << outcome.err;
        EXPECT_NE(outcome.err.find(place.substr(place.find('=') + 1)), std::string::npos)
            << outcome.err;
    }
    // Where nothing can be, nothing is missing.
    const Outcome outcome = run_program(command, {"BRDFIT_TUNING=" + (folder_ / "file/t.json")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;
    {
        const Variable tuning("BRDFIT_TUNING", loop.c_str());
        EXPECT_THROW(store_tuned_form(untuned_, other_), InputError);
    }
}

TEST_F(Tune, an_unwritable_place_is_an_error) {
    write_file(folder_ / "file", "");
    const Variable tuning("BRDFIT_TUNING", (folder_ / "file/tuning.json").c_str());
    EXPECT_THROW(store_tuned_form(untuned_, other_), std::runtime_error);
    const Outcome outcome = run_program({"tune", "--samples", "1000", "--forms", "1"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("file"), std::string::npos) << outcome.err;
}

TEST(TuningPath, is_where_configuration_belongs) {
    {
        const Variable tuning("BRDFIT_TUNING", "/a/b.json");
        EXPECT_EQ(tuning_path(), "/a/b.json");
    }
    const Variable tuning("BRDFIT_TUNING", nullptr), home("HOME", "/home/someone"),
        none("XDG_CONFIG_HOME", nullptr);
    EXPECT_EQ(tuning_path(), "/home/someone/.config/brdfit/tuning.json");
    {
        const Variable config("XDG_CONFIG_HOME", "/config");
        EXPECT_EQ(tuning_path(), "/config/brdfit/tuning.json");
        const Variable untuned("BRDFIT_TUNING", "");
        EXPECT_EQ(tuning_path(), "");
    }
}

} // namespace brdfit::test

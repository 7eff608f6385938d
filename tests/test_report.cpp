// brdfit report as its users meet it: one page that holds every fit, needs no other file and says
// what failed.

#include "tests/support/runs.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace brdfit {

namespace {

using namespace test;

class Report : public Runs {
  protected:
    Outcome report(const std::vector<std::string>& options = {}, const std::string& run = "run") {
        std::vector<std::string> command{"report", folder / run, "-o", folder / "page.html"};
        command.insert(command.end(), options.begin(), options.end());
        if (std::find(options.begin(), options.end(), "--size") == options.end())
            command.insert(command.end(), {"--size", "0"}); // no pictures
        return run_program(command);
    }
    std::string page() const { return read_file(folder / "page.html"); }
    bool has(const std::string& text) const { return page().find(text) != std::string::npos; }
};

std::size_t count_of(const std::string& what, const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
        ++count;
    return count;
}

/// Whether every element that opens closes, in order: the page is also XML but for its first line.
std::string unclosed_element(const std::string& page) {
    std::vector<std::string> open;
    for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
        if (page.compare(at, 2, "<!") == 0)
            continue;
        const std::size_t end = page.find('>', at);
        const bool closes = page[at + 1] == '/';
        std::string name;
        for (std::size_t k = at + (closes ? 2 : 1);
             std::isalnum(static_cast<unsigned char>(page[k])) != 0; ++k)
            name += page[k];
        if (closes && (open.empty() || open.back() != name))
            return "</" + name + ">";
        if (closes)
            open.pop_back();
        else if (page[end - 1] != '/')
            open.push_back(name);
        if (!closes && (name == "script" || name == "style"))
            at = page.find("</" + name, at) - 1;
    }
    return open.empty() ? "" : open.back();
}

TEST_F(Report, holds_every_fit_and_needs_no_other_file) {
    plan({"-m", "lambert,ward,kurt", "--lobes", "1,2"});
    ASSERT_EQ(run().status, 0);
    const Outcome outcome = report();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("15 fits, 0 failed; materials: 3"), std::string::npos)
        << outcome.out;
    const std::string text = page();
    EXPECT_EQ(unclosed_element(text), "");
    EXPECT_EQ(text.find("{{"), std::string::npos);
    for (const char* reference : {"http:", "https:", "file:", "src=\"/", "href=\"/", "@import"})
        EXPECT_EQ(text.find(reference), std::string::npos) << reference;
    // Each fit is a cell of the tables of errors.
    const std::size_t begin = text.find("id=\"errors\""), end = text.find("id=\"materials\"");
    ASSERT_LT(begin, end);
    const std::string errors = text.substr(begin, end - begin);
    const std::string body = errors.substr(0, errors.find("<script>"));
    EXPECT_EQ(count_of("<td data-v=\"", body) + count_of("<td class=\"best\" data-v=\"", body), 15U)
        << body;
}

TEST_F(Report, draws_pictures_of_the_data_and_of_fits) {
    write_file(folder / "colours.json", R"({"brdfit": 1, "channels": ["R", "G", "B"],
        "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
        "lobes": [{"model": "ward", "ks": [0.1, 0.1, 0.1], "m": 0.2}]})");
    ASSERT_EQ(
        run_program({"synth", folder / "colours.json", folder / "c.csv", "--directions", "100"})
            .status,
        0);
    ASSERT_EQ(
        run_program({"fit", folder / "c.csv", "-m", "lambert,ward", "-o", folder / "fits"}).status,
        0);
    const Outcome outcome = report({"--size", "16", "--samples", "4"}, "fits");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::string text = page();
    EXPECT_EQ(unclosed_element(text), "");
    EXPECT_GE(count_of("src=\"data:image/jpeg;base64,", text), 3U); // data, best fit, difference
    EXPECT_EQ(count_of("<img ", text), count_of("alt=\"", text));
    EXPECT_NE(text.find("PSNR"), std::string::npos);
    EXPECT_NE(text.find("FLIP"), std::string::npos);
}

TEST_F(Report, restricts_materials_and_models) {
    plan();
    ASSERT_EQ(run().status, 0);
    ASSERT_EQ(report({"--materials", "b", "--models", "ward"}).status, 0);
    const std::string head = R"(<button type="button">)"; // of a table's column
    EXPECT_FALSE(has(head + "kurt"));
    EXPECT_TRUE(has(head + "ward"));
    EXPECT_FALSE(has("data-name=\"a\""));
    EXPECT_TRUE(has("data-name=\"b\""));
    expect_usage_error(report({"--force", "--models", "nothing"}), "nothing");
    expect_usage_error(report({"--force", "--materials", "nothing*"}), "nothing");
    EXPECT_FALSE(has(head + "kurt")); // the page before is still there
}

TEST_F(Report, replaces_no_page_in_silence_and_looks_at_endings_first) {
    plan({"-m", "lambert"});
    ASSERT_EQ(run().status, 0);
    ASSERT_EQ(report().status, 0);
    const std::string before = page();
    const Outcome outcome = report();
    EXPECT_NE(outcome.status, 0);
    EXPECT_NE(outcome.err.find("--force"), std::string::npos) << outcome.err;
    EXPECT_EQ(page(), before);
    EXPECT_EQ(report({"--force"}).status, 0);
    expect_usage_error(run_program({"report", folder / "run", "-o", folder / "page.pdf"}), ".html");
    expect_usage_error(report({"--force", "--samples", "9"}), "--samples");
    expect_input_error(run_program({"report", folder / "none", "-o", folder / "p.html"}), "none");
    EXPECT_FALSE(std::filesystem::exists(folder / "p.html"));
}

TEST_F(Report, tells_of_failed_fits_and_broken_lines) {
    plan({"-m", "lambert,ward"});
    std::filesystem::remove(folder / "b.csv");
    run();
    ASSERT_EQ(report().status, 0);
    EXPECT_TRUE(has("b.csv"));
    EXPECT_TRUE(has("2 failed"));
    std::string text = read_file(log());
    text[text.size() / 2] ^= 1;
    write_file(log(), text);
    const Outcome outcome = report({"--force"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("0-of-1.jsonl"), std::string::npos) << outcome.err;
    EXPECT_TRUE(has("0-of-1.jsonl"));
}

TEST_F(Report, escapes_what_comes_from_names) {
    std::filesystem::rename(folder / "b.csv", folder / "<b>&amp;.csv");
    ASSERT_EQ(
        run_program({"fit", folder / "<b>&amp;.csv", "-m", "lambert,ward", "-o", folder / "fits"})
            .status,
        0);
    ASSERT_EQ(report({}, "fits").status, 0);
    EXPECT_EQ(unclosed_element(page()), "");
    EXPECT_FALSE(has("<b>"));
    EXPECT_TRUE(has("&lt;b&gt;&amp;amp;"));
}

} // namespace

} // namespace brdfit

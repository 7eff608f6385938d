// What the README files say of the tree and of the program: links lead somewhere, commands exist.

#include "tests/support/support.hpp"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace brdfit::test;
namespace fs = std::filesystem;

const fs::path root = BRDFIT_SOURCES;

std::vector<fs::path> readmes() {
    std::vector<fs::path> files = {root / "README.md"};
    for (const char* floor : {"kernels", "host", "fit", "bench", "tests"})
        for (const auto& entry : fs::recursive_directory_iterator(root / floor))
            if (entry.path().filename() == "README.md")
                files.push_back(entry.path());
    return files;
}

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
    std::vector<std::string> found;
    for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i)
        found.push_back((*i)[1]);
    return found;
}

// The anchor that a heading gets: lower case, spaces to hyphens, other marks dropped.
std::set<std::string> anchors_of(const fs::path& file) {
    std::set<std::string> anchors;
    for (const std::string& heading :
         matches(read_file(file.string()), std::regex("(?:^|\n)#+ ([^\n]*)"))) {
        std::string anchor;
        for (const char c : heading)
            if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
                anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            else if (c == ' ')
                anchor += '-';
        anchors.insert(anchor);
    }
    return anchors;
}

TEST(Readme, is_a_tour_of_at_most_200_lines) {
    const std::string text = read_file((root / "README.md").string());
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 200);
}

TEST(Readme, links_lead_to_files_and_headings) {
    std::size_t seen = 0;
    const std::regex link(R"(\]\(([^)\s]+)\))");
    for (const fs::path& file : readmes())
        for (const std::string& target : matches(read_file(file.string()), link)) {
            if (target.find("://") != std::string::npos)
                continue;
            const std::size_t hash = target.find('#');
            const fs::path path = hash == 0 ? file : file.parent_path() / target.substr(0, hash);
            ++seen;
            ASSERT_TRUE(fs::exists(path)) << file << ": " << target;
            if (hash != std::string::npos) {
                EXPECT_EQ(anchors_of(path).count(target.substr(hash + 1)), 1U)
                    << file << ": " << target << ": no such heading";
            }
        }
    EXPECT_GT(seen, 25U);
}

// The lines of fenced blocks, and what stands between backticks, a line each.
std::string code_of(const std::string& text) {
    std::string code, line;
    bool fenced = false;
    for (std::istringstream lines(text); std::getline(lines, line);) {
        if (line.rfind("```", 0) == 0)
            fenced = !fenced;
        else if (fenced)
            code += line + "\n";
        else
            for (const std::string& piece : matches(line, std::regex("`([^`]+)`")))
                code += piece + "\n";
    }
    return code;
}

// Of the list in the program's help.
std::set<std::string> commands() {
    const std::string help = run_program({"--help"}).out;
    const std::vector<std::string> names =
        matches(help.substr(help.find("Subcommands:")), std::regex("\n  ([a-z]+) "));
    std::set<std::string> all(names.begin(), names.end());
    if (help.find("no bench and tune") != std::string::npos) // a build may leave them out
        all.insert({"bench", "tune"});
    return all;
}

TEST(Readme, names_commands_that_exist) {
    const std::set<std::string> known = commands();
    std::set<std::string> seen;
    const std::regex command(R"((?:^|\n|[;&|] |\$ |build/)brdfit ([a-z]+)\b)");
    for (const fs::path& file : readmes())
        for (const std::string& name : matches(code_of(read_file(file.string())), command)) {
            seen.insert(name);
            EXPECT_EQ(known.count(name), 1U) << file << ": brdfit " << name;
        }
    EXPECT_GE(seen.size(), 13U);
}

} // namespace

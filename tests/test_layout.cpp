// The floors and rooms of the source tree: what may include what.

#include "tests/support/support.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace {

using namespace brdfit::test;
namespace fs = std::filesystem;

// From the ground up. What stands in one list includes only its own room and earlier lists; rooms
// of one list do not know each other. host's own files are the ground of host, apart from its
// rooms.
const std::vector<std::vector<std::string>> order = {
    {"kernels/base"},   {"kernels/terms"}, {"kernels/models"},
    {"kernels/passes"}, {"host"},          {"host/files"},
    {"host/image"},     {"host/device"},   {"host/measured", "host/microfacet"},
    {"host/model"},     {"host/evaluate"}, {"host/albedo"},
    {"host/table"},     {"host/cli"},      {"fit"},
    {"fit/cli"},        {"bench/native"},  {"bench"},
    {"bench/cli"},      {"bench/micro"},   {"tests/support"},
    {"tests"},
};

// The level of a room, or -1 where the list has none of that name.
int level_of(const std::string& room) {
    for (std::size_t i = 0; i < order.size(); ++i)
        if (std::find(order[i].begin(), order[i].end(), room) != order[i].end())
            return static_cast<int>(i);
    return -1;
}

const fs::path root = BRDFIT_SOURCES;

std::vector<fs::path> sources() {
    std::vector<fs::path> files;
    for (const char* floor : {"kernels", "host", "fit", "bench", "tests"})
        for (const auto& entry : fs::recursive_directory_iterator(root / floor)) {
            const std::string ending = entry.path().extension().string();
            if (ending == ".cpp" || ending == ".hpp" || ending == ".h" || ending == ".cl")
                files.push_back(fs::relative(entry.path(), root));
        }
    std::sort(files.begin(), files.end());
    return files;
}

// Paths below the root that a file includes.
std::vector<std::string> includes_of(const fs::path& file) {
    static const std::regex line("^\\s*#\\s*include\\s+\"([^\"]+)\"");
    std::vector<std::string> included;
    std::istringstream text(read_file((root / file).string()));
    std::smatch match;
    for (std::string each; std::getline(text, each);)
        if (std::regex_search(each, match, line))
            included.push_back(match[1]);
    return included;
}

TEST(Layout, every_source_file_stands_in_a_known_room) {
    ASSERT_GT(sources().size(), 200U);
    for (const fs::path& file : sources())
        EXPECT_GE(level_of(file.parent_path().string()), 0)
            << file << ": its room is not in the list of rooms above";
}

TEST(Layout, no_include_runs_up) {
    std::size_t seen = 0;
    for (const fs::path& file : sources()) {
        const std::string room = file.parent_path().string();
        for (const std::string& name : includes_of(file)) {
            if (name.find('/') == std::string::npos)
                continue; // generated
            const std::string other = fs::path(name).parent_path().string();
            ++seen;
            EXPECT_TRUE(other == room || level_of(other) < level_of(room))
                << file << " includes " << name << ", which stands above it";
        }
    }
    EXPECT_GT(seen, 500U);
}

// brdfit_core is everything of host and fit but the command line.
TEST(Layout, the_library_knows_no_command_line) {
    for (const fs::path& file : sources()) {
        const std::string name = file.string();
        const bool core = (name.rfind("host/", 0) == 0 || name.rfind("fit/", 0) == 0) &&
                          name.find("/cli/") == std::string::npos;
        if (!core)
            continue;
        EXPECT_EQ(read_file((root / file).string()).find("CLI/"), std::string::npos) << file;
        for (const std::string& included : includes_of(file))
            EXPECT_EQ(included.find("/cli/"), std::string::npos) << file << ": " << included;
    }
}

} // namespace

// The floors and rooms of the source tree: what may include what.

#include "tests/support/support.hpp"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace brdfit::test;
namespace fs = std::filesystem;

// From the ground up. What stands in one list includes only its own room and earlier lists; rooms
// of one list do not know each other. host's own files are the ground of host, apart from its
// rooms.
const std::vector<std::vector<std::string>> order = {
    {"kernels/base"},
    {"kernels/terms"},
    {"kernels/models"},
    {"kernels/scene"},
    {"kernels/passes"},
    {"host"},
    {"host/files"},
    {"host/image"},
    {"host/device"},
    {"host/measured", "host/microfacet"},
    {"host/model"},
    {"host/evaluate"},
    {"host/albedo"},
    {"host/table"},
    {"host/render"},
    {"host/cli"},
    {"fit"},
    {"fit/runs"},
    {"fit/report"},
    {"fit/python"},
    {"fit/cli"},
    {"bench/native"},
    {"bench"},
    {"bench/cli"},
    {"bench/micro"},
    {"tests/support"},
    {"tests/fuzz"},
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

// What CMake makes, by the name it is included by.
const std::vector<std::string> generated = {"host/version.hpp", "scalar_models.inc"};

// What is wrong with a line of a file; empty where it includes nothing, or what it may.
std::string offence(const fs::path& file, const std::string& line) {
    static const std::regex any("^\\s*#\\s*(include|include_next|import)\\b.*");
    static const std::regex plain("^\\s*#\\s*include\\s*([<\"])([^\">]+)[\">]\\s*(//.*)?$");
    std::smatch match;
    if (!std::regex_match(line, any))
        return "";
    if (!std::regex_match(line, match, plain))
        return "is no plain #include";
    const std::string name = match[2];
    const bool quoted = match[1] == "\"";
    const std::string floor = name.substr(0, name.find('/'));
    const bool ours = floor != name && fs::is_directory(root / floor);
    if (!quoted && !ours)
        return ""; // a library's
    if (!quoted)
        return "includes a file of this tree as a library's";
    if (std::find(generated.begin(), generated.end(), name) != generated.end())
        return "";
    if (!fs::is_regular_file(root / name) || fs::path(name).lexically_normal() != name)
        return "does not name a file by its path from the root";
    const std::string room = file.parent_path().string(),
                      other = fs::path(name).parent_path().string();
    return other == room || (level_of(other) >= 0 && level_of(other) < level_of(room))
               ? ""
               : "includes what stands above it";
}

// Calls body(line) for each line of a file.
template <typename Body>
void each_line(const fs::path& file, Body body) {
    std::istringstream text(read_file((root / file).string()));
    for (std::string line; std::getline(text, line);)
        body(line);
}

bool starts_with(const std::string& text, const std::string& beginning) {
    return text.rfind(beginning, 0) == 0;
}

// Whether a file is of brdfit_core: everything of host and fit but the command line and the Python
// module.
bool is_of_the_library(const fs::path& file) {
    const std::string name = file.string();
    return (starts_with(name, "host/") || starts_with(name, "fit/")) &&
           name.find("/cli/") == std::string::npos && !starts_with(name, "fit/python/");
}

TEST(Layout, every_source_file_stands_in_a_known_room) {
    ASSERT_GT(sources().size(), 200U);
    for (const fs::path& file : sources())
        EXPECT_GE(level_of(file.parent_path().string()), 0)
            << file << ": its room is not in the list of rooms above";
}

TEST(Layout, no_include_runs_up) {
    std::size_t seen = 0;
    for (const fs::path& file : sources())
        each_line(file, [&](const std::string& line) {
            seen += line.find("#include \"") != std::string::npos;
            EXPECT_EQ(offence(file, line), "") << file << ": " << line;
        });
    EXPECT_GT(seen, 500U);
}

TEST(Layout, an_include_that_runs_up_is_seen_however_it_is_written) {
    const fs::path low = "host/measured/merl.cpp";
    for (const char* line :
         {"#include \"host/measured/samples.hpp\"", "#include \"host/files/file.hpp\" // bytes",
          "#include <vector>", "#include <CL/opencl.hpp>", "#include \"host/version.hpp\"", "",
          "// #include \"fit/fit.hpp\""})
        EXPECT_EQ(offence(low, line), "") << line;
    for (const char* line :
         {"#include \"host/model/material.hpp\"", "  #  include\t\"fit/fit.hpp\"",
          "#include\"host/cli/command.hpp\"", "#include \"host/microfacet/table.hpp\"",
          "#include <host/model/material.hpp>", "#include <tests/support/support.hpp>",
          "#include \"samples.hpp\"", "#include \"../model/material.hpp\"",
          "#include \"host/measured/../model/material.hpp\"", "#include \"./merl.hpp\"",
          "#include \"bench/work.hpp\" // why", "#include MATERIAL",
          "#include /**/ \"fit/fit.hpp\"", "#include_next \"fit/fit.hpp\""})
        EXPECT_NE(offence(low, line), "") << line;
    EXPECT_NE(offence("kernels/terms/erf.cl", "#include \"kernels/models/ward.cl\""), "");
    EXPECT_NE(offence("fit/fit.cpp", "#include \"fit/cli/fit_files.hpp\""), "");
    EXPECT_EQ(offence("bench/cli/tune.cpp", "#include \"fit/fit.hpp\""), "");
}

TEST(Layout, the_library_knows_no_command_line) {
    for (const fs::path& file : sources()) {
        const bool parses = read_file((root / file).string()).find("<CLI/") != std::string::npos;
        EXPECT_FALSE(parses && is_of_the_library(file)) << file;
    }
}

// The program that links the library keeps its own logger, handlers and locale, and decides when it
// ends.
TEST(Layout, the_library_changes_nothing_of_its_process) {
    const std::regex global(
        "set_default_logger|spdlog::(register|set_|drop|shutdown|apply|init)|\\bsignal\\(|"
        "sigaction|setlocale|locale::global|set_terminate|set_new_handler|atexit|"
        "\\b(exit|abort|_exit|quick_exit)\\(|\\b(set|put|unset)env\\(|\\bchdir\\(|"
        "current_path\\(|\\bs?rand\\(|sync_with_stdio");
    EXPECT_TRUE(std::regex_search("std::signal(SIGINT, handler);", global));
    std::size_t seen = 0;
    for (const fs::path& file : sources())
        if (is_of_the_library(file))
            each_line(file, [&](const std::string& line) {
                ++seen;
                EXPECT_FALSE(std::regex_search(line.substr(0, line.find("//")), global))
                    << file << ": " << line;
            });
    EXPECT_GT(seen, 5000U);
}

// C99's plain inline leaves it to the driver whether a function is there at all when it is not
// inlined.
TEST(Layout, inline_functions_of_kernels_are_static) {
    const std::regex any("\\binline\\b");
    std::size_t seen = 0;
    for (const fs::path& file : sources())
        if (*file.begin() == "kernels")
            each_line(file, [&](const std::string& line) {
                const std::string code = line.substr(0, line.find("//"));
                if (!std::regex_search(code, any))
                    return;
                ++seen;
                EXPECT_NE(code.find("static inline"), std::string::npos) << file << ": " << line;
            });
    EXPECT_GT(seen, 100U);
}

} // namespace

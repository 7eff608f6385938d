#include "tests/support/support.hpp"

#include "host/embedded.hpp"
#include "host/microfacet/generator.hpp"

#include <algorithm>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <spawn.h>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace brdfit::test {

TemporaryFolder::TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "brdfit-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr)
        throw std::runtime_error("cannot make a temporary folder " + pattern);
    path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

void write_file(const std::string& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file)
        throw std::runtime_error("cannot write " + path);
}

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw std::runtime_error("cannot read " + path);
    return {std::istreambuf_iterator<char>(file), {}};
}

Outcome run_command(const std::vector<std::string>& command,
                    const std::vector<std::string>& environment,
                    const std::function<void(pid_t)>& meanwhile) {
    const TemporaryFolder folder;
    const std::string out = folder / "out", err = folder / "err";
    std::vector<char*> argv;
    for (const std::string& argument : command)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    // The first of several values of a variable counts.
    std::vector<char*> variables;
    for (const std::string& variable : environment)
        variables.push_back(const_cast<char*>(variable.c_str()));
    for (char** variable = environ; *variable != nullptr; ++variable)
        variables.push_back(*variable);
    variables.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const int flags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), flags, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), flags, 0600);
    pid_t child = 0;
    const int error =
        posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), variables.data());
    posix_spawn_file_actions_destroy(&actions);
    if (error == 0 && meanwhile)
        meanwhile(child);
    int status = 0;
    if (error != 0 || waitpid(child, &status, 0) != child)
        throw std::runtime_error("cannot run " + command[0]);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_file(out),
            read_file(err)};
}

Outcome run_program(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment,
                    const std::function<void(pid_t)>& meanwhile) {
    std::vector<std::string> command{BRDFIT_PROGRAM};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_command(command, environment, meanwhile);
}

void limit_memory(std::size_t more) {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t most = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + more;
    const rlimit limit{most, most};
    if (setrlimit(RLIMIT_AS, &limit) != 0)
        throw std::runtime_error("cannot limit the memory");
}

Variable::Variable(const std::string& name, const char* value) : name_(name) {
    if (const char* const before = std::getenv(name.c_str()))
        before_ = before;
    if (value == nullptr)
        unsetenv(name.c_str());
    else
        setenv(name.c_str(), value, 1);
}

Variable::~Variable() {
    if (before_)
        setenv(name_.c_str(), before_->c_str(), 1);
    else
        unsetenv(name_.c_str());
}

KernelFolder::KernelFolder(const std::string& file, const std::string& from,
                           const std::string& to) {
    bool changed = file.empty();
    for (const EmbeddedFile* kernel = embedded_kernels; kernel->name != nullptr; ++kernel) {
        std::string text = kernel->text;
        if (kernel->name == file) {
            const std::size_t place = text.find(from);
            if (place == std::string::npos)
                throw std::runtime_error(file + " has no " + from);
            text.replace(place, from.size(), to);
            changed = true;
        }
        const std::string path = folder_ / kernel->name;
        std::filesystem::create_directories(std::filesystem::path(path).parent_path());
        write_file(path, text);
    }
    if (!changed)
        throw std::runtime_error("there is no kernel file " + file);
}

std::string kernel_text(const std::string& file) {
    for (const EmbeddedFile* kernel = embedded_kernels; kernel->name != nullptr; ++kernel)
        if (kernel->name == file)
            return kernel->text;
    throw std::runtime_error("there is no kernel file " + file);
}

std::filesystem::path data_folder() {
    const char* folder = std::getenv("BRDFIT_DATA");
    return folder == nullptr ? "" : folder;
}

std::vector<double> told_shares(const std::function<void(const ProgressFunction&)>& action) {
    std::vector<double> shares;
    action([&](double share) { shares.push_back(share); });
    EXPECT_GT(shares.size(), 2U);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    for (const double share : shares) {
        EXPECT_GE(share, 0);
        EXPECT_LE(share, 1 + 1e-12);
    }
    return shares;
}

const Device& device() {
    static const Device opened = open_device();
    return opened;
}

const Generator& generator() {
    static const Generator one(device());
    return one;
}

} // namespace brdfit::test

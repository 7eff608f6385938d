#include "bench/again.hpp"

#include "host/error.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace brdfit::bench {

namespace {

// Whether an entry of the environment sets one of the variables.
bool sets_any(const std::string& entry,
              const std::vector<std::pair<std::string, std::string>>& variables) {
    for (const auto& variable : variables)
        if (entry.rfind(variable.first + "=", 0) == 0)
            return true;
    return false;
}

} // namespace

std::string run_again(const std::vector<std::string>& arguments,
                      const std::vector<std::pair<std::string, std::string>>& variables) {
    std::string program = "/proc/self/exe";
    std::vector<char*> argv{program.data()}, environment;
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    std::vector<std::string> settings;
    for (char** entry = environ; *entry != nullptr; ++entry)
        if (!sets_any(*entry, variables))
            settings.emplace_back(*entry);
    for (const auto& [name, value] : variables)
        settings.push_back(fmt::format("{}={}", name, value));
    for (std::string& setting : settings)
        environment.push_back(setting.data());
    environment.push_back(nullptr);

    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        throw InputError(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    pid_t child = 0;
    const int error =
        posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environment.data());
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    std::string output;
    char buffer[4096];
    for (ssize_t n = 1; error == 0 && n != 0;) {
        n = read(ends[0], buffer, sizeof buffer);
        if (n > 0)
            output.append(buffer, static_cast<std::size_t>(n));
        else if (n < 0 && errno != EINTR)
            break;
    }
    close(ends[0]);
    if (error != 0)
        throw InputError(fmt::format("cannot run this program again: {}", std::strerror(error)));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw InputError("the part of the benchmark with an environment of its own failed");
    return output;
}

} // namespace brdfit::bench

#include "bench/opencl.hpp"

#include "fit/objective.hpp"
#include "host/error.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace brdfit::bench {

std::vector<Result> measure_device(const Device& device, const Problem& problem,
                                   const Samples& samples) {
    constexpr double whole_hemisphere = 90;
    const Structure structure = structure_of(parse_material(problem.material, "problem"));
    const DeviceSamples packed = pack_samples(device, samples, whole_hemisphere, Metric::Ngan);
    ProgramCache cache(device);
    Objective objective(device, cache.get(structure, packed.channels, packed.chunk), packed);
    std::vector<Result> results;
    for (const Work& work : works) {
        Result result;
        result.device = device.name;
        result.work = work.name;
        result.model = structure.name();
        result.threads = static_cast<int>(device.compute_units);
        result.bytes_per_sample =
            static_cast<double>(sizeof(float)) * (objective.layout().planes + packed.channels + 1);
        const Timing timing = time_runs([&] {
            result.answer.error = objective.projected_error(
                problem.theta, work.gradient ? &result.answer.gradient : nullptr);
        });
        result.samples_per_second = static_cast<double>(packed.count) / timing.median;
        result.spread = timing.spread;
        results.push_back(std::move(result));
    }
    return results;
}

bool can_run_on_one_thread(const Device& device) {
    return device.cpu && device.platform == "Portable Computing Language";
}

std::string run_on_one_thread(const std::vector<std::string>& arguments) {
    constexpr const char* variable = "POCL_MAX_PTHREAD_COUNT=";
    std::string program = "/proc/self/exe", limit = std::string(variable) + "1";
    std::vector<char*> argv{program.data()}, environment{limit.data()};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    for (char** entry = environ; *entry != nullptr; ++entry)
        if (std::strncmp(*entry, variable, std::strlen(variable)) != 0)
            environment.push_back(*entry);
    environment.push_back(nullptr);

    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        throw InputError(fmt::format("one thread: cannot make a pipe: {}", std::strerror(errno)));
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
        throw InputError(
            fmt::format("one thread: cannot run this program again: {}", std::strerror(error)));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw InputError("one thread: the run limited to one thread failed");
    return output;
}

} // namespace brdfit::bench

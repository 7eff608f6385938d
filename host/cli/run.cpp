#include "host/cli/command.hpp"
#include "host/device/errors.hpp"
#include "host/device/kernels.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fmt/format.h>
#include <memory>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace brdfit::cli {

namespace {

constexpr AddCommand commands[] = {
    add_devices, add_models, add_info,   add_synth,  add_convert, add_fit,
    add_eval,    add_pdf,    add_sample, add_albedo, add_table,   add_generate,
    add_compare, add_render, add_plot,   add_demo,   add_plan,    add_run_shard,
    add_status,  add_merge,  add_report, add_cache,
#ifdef BRDFIT_BENCH
    add_bench,   add_tune,
#endif
};

// The program's messages go to stderr through a logger of its own, which is the default one while
// a command runs; the caller's comes back afterwards.
class Messages {
  public:
    Messages() : before_(spdlog::default_logger()) {
        auto log = std::make_shared<spdlog::logger>(
            "brdfit", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
        log->set_pattern("brdfit: %^%l%$: %v");
        spdlog::set_default_logger(log);
    }
    ~Messages() { spdlog::set_default_logger(before_); }
    Messages(const Messages&) = delete;
    Messages& operator=(const Messages&) = delete;

  private:
    std::shared_ptr<spdlog::logger> before_;
};

extern "C" void clean_up_and_die(int signal) {
    remove_open_temporaries();
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

extern "C" void explain_and_die(int signal) {
    static std::atomic_flag explained = ATOMIC_FLAG_INIT;
    while (explained.test_and_set()) // another thread crashed first, and ends the program
        pause();
    const char* const driver = last_build();
    for (const char* text :
         {"brdfit: error: the program crashed", driver != nullptr ? ", perhaps in the driver " : "",
          driver != nullptr ? driver : "", "\n"})
        if (write(STDERR_FILENO, text, std::strlen(text)) < 0)
            break; // then nobody reads it
    clean_up_and_die(signal);
}

// A file that is read may become shorter; its reader says so.
extern "C" void mend_or_die(int signal, siginfo_t* info, void*) {
    if (info->si_code <= 0 || !replace_cut_page(info->si_addr))
        explain_and_die(signal);
}

// Until the command ends, a signal that ends the program first removes its temporary files. What
// was ignored (nohup) stays so, and so do others' handlers of crashes (a sanitizer's). The ignored
// is blocked as well: a driver's compiler (LLVM) sets handlers of its own while it builds, by
// which a signal takes its files from under it.
class Signals {
  public:
    Signals() {
        sigset_t ignored;
        sigemptyset(&ignored);
        for (std::size_t i = 0; i < before_.size(); ++i) {
            const bool crash = i >= ends;
            sigaction(caught[i], nullptr, &before_[i]);
            if (before_[i].sa_handler == SIG_IGN && !crash)
                sigaddset(&ignored, caught[i]);
            if (before_[i].sa_handler == SIG_IGN || (crash && before_[i].sa_handler != SIG_DFL))
                continue;
            struct sigaction now {};
            now.sa_handler = crash ? explain_and_die : clean_up_and_die;
            if (caught[i] == SIGBUS) {
                now.sa_sigaction = mend_or_die;
                now.sa_flags = SA_SIGINFO;
            }
            sigaction(caught[i], &now, nullptr);
        }
        pthread_sigmask(SIG_BLOCK, &ignored, &mask_before_); // threads to come inherit it
    }
    ~Signals() {
        pthread_sigmask(SIG_SETMASK, &mask_before_, nullptr);
        for (std::size_t i = 0; i < before_.size(); ++i)
            sigaction(caught[i], &before_[i], nullptr);
    }
    Signals(const Signals&) = delete;
    Signals& operator=(const Signals&) = delete;

  private:
    static constexpr std::size_t ends = 4; // then crashes
    static constexpr std::array caught{SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGSEGV, SIGBUS, SIGABRT};
    std::array<struct sigaction, caught.size()> before_{};
    sigset_t mask_before_{};
};

// Throws InputError where not all of the standard output could be written.
void flush_results() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw InputError("standard output: cannot write the results");
}

constexpr int bad_input = 1, wrong_usage = 2;

/// The commands below one, those that begin like `name` first.
std::string known_commands(const CLI::App& of, const std::string& name) {
    std::vector<std::string> names;
    for (const CLI::App* command : of.get_subcommands({}))
        names.push_back(command->get_name());
    const auto alike = [&](const std::string& known) {
        return std::mismatch(known.begin(), known.end(), name.begin(), name.end()).first -
               known.begin();
    };
    std::stable_sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
        return alike(a) > alike(b);
    });
    return fmt::format("{}", fmt::join(names, ", "));
}

/// What stands where a command is expected; empty where nothing does.
std::string unknown_command(const CLI::App& app) {
    if (!app.get_subcommands().empty())
        return "";
    for (const std::string& argument : app.remaining())
        if (!argument.empty() && argument[0] != '-')
            return argument;
    return "";
}

/// What was begun: brdfit bench sampling, say.
std::string parsed_command(const CLI::App& app) {
    std::string command = app.get_parent() == nullptr ? "brdfit" : app.get_name();
    for (const CLI::App* below : app.get_subcommands())
        command += " " + parsed_command(*below);
    return command;
}

} // namespace

int run(int argc, char** argv) {
    // An empty one is as none; PoCL would abort.
    if (const char* const folder = std::getenv("POCL_CACHE_DIR"); folder != nullptr && *folder == 0)
        unsetenv("POCL_CACHE_DIR");
    const Signals signals;
    const Messages messages;

    Globals globals;
    Action action;
    CLI::App app{"brdfit: evaluates BRDF models and fits them to measured reflectance with OpenCL\n"
                 "brdfit help COMMAND tells of one command"};
    app.set_version_flag("--version", version);
    app.require_subcommand(1);
    app.fallthrough();
#ifndef BRDFIT_BENCH
    app.footer("This build has no bench and tune; cmake -DBRDFIT_BENCH=ON adds them.");
#endif
    app.add_option("--device", globals.device,
                   "OpenCL device: its index, or a part of its name, platform or vendor; fit, run, "
                   "bench and tune take several, with commas, or all");
    auto* quiet = app.add_flag("-q,--quiet", globals.quiet, "only errors and results");
    app.add_flag("-v,--verbose", globals.verbose, "say what is done and how fast")->excludes(quiet);
    for (AddCommand add : commands)
        add(app, globals, action);
    // help COMMAND is COMMAND --help.
    std::vector<const char*> arguments(argv, argv + argc);
    if (argc > 1 && std::string_view(argv[1]) == "help") {
        const CLI::App* of = &app;
        for (int i = 2; i < argc; ++i) {
            const auto named = of->get_subcommands(
                [&](const CLI::App* command) { return command->check_name(argv[i]); });
            if (named.empty()) {
                spdlog::error("help {}: no such command; known: {}", argv[i],
                              known_commands(*of, argv[i]));
                return wrong_usage;
            }
            of = named.front();
        }
        arguments.erase(arguments.begin() + 1);
        arguments.push_back("--help");
    }
    try {
        app.parse(static_cast<int>(arguments.size()), arguments.data());
    } catch (const CLI::ParseError& error) {
        if (const std::string name = unknown_command(app); !name.empty()) {
            spdlog::error("{}: no such command; known: {}", name, known_commands(app, name));
            return wrong_usage;
        }
        if (error.get_exit_code() != 0) {
            spdlog::error("{}; see {} --help", error.what(), parsed_command(app));
            return wrong_usage;
        }
        app.exit(error);
        try {
            flush_results(); // help
        } catch (const InputError& unwritten) {
            spdlog::error("{}", unwritten.what());
            return bad_input;
        }
        return 0;
    }
    for (const char* without : {"models", "info", "plan", "status", "merge", "cache"})
        if (!globals.device.empty() && app.got_subcommand(without)) {
            spdlog::error("--device: {} runs on no device", without);
            return wrong_usage;
        }
    spdlog::default_logger()->set_level(globals.quiet     ? spdlog::level::err
                                        : globals.verbose ? spdlog::level::debug
                                                          : spdlog::level::info);
    try {
        take_replaced_files(); // of an earlier run
        const int status = action();
        if (const std::vector<std::string> files = take_replaced_files(); !files.empty())
            spdlog::info(fmt::runtime(files.size() == 1
                                          ? "{} was there and is replaced"
                                          : "{} and {} more were there and are replaced"),
                         files.front(), files.size() - 1);
        flush_results();
        return status;
    } catch (const UsageError& error) {
        spdlog::error("{}", error.what());
        return wrong_usage;
    } catch (const std::exception& error) {
        spdlog::error("{}", message_of(error));
        return bad_input;
    }
}

} // namespace brdfit::cli

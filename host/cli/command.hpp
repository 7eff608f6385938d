#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <string>

namespace brdfit::cli {

/// Options every sub-command has.
struct Globals {
    std::string
        device; ///< --device: index or part of a name, platform's or vendor's; empty: the default
    bool quiet = false;
    bool verbose = false;
};

/// Runs the chosen sub-command; returns the exit status.
using Action = std::function<int()>;

/// Each adds its sub-command to `app` and, when it is chosen, sets `action`. One file each.
using AddCommand = void (*)(CLI::App& app, const Globals& globals, Action& action);
void add_devices(CLI::App& app, const Globals& globals, Action& action);
void add_cache(CLI::App& app, const Globals& globals, Action& action);
void add_models(CLI::App& app, const Globals& globals, Action& action);
void add_info(CLI::App& app, const Globals& globals, Action& action);
void add_synth(CLI::App& app, const Globals& globals, Action& action);
void add_convert(CLI::App& app, const Globals& globals, Action& action);
void add_fit(CLI::App& app, const Globals& globals, Action& action);
void add_eval(CLI::App& app, const Globals& globals, Action& action);
void add_compare(CLI::App& app, const Globals& globals, Action& action);
void add_demo(CLI::App& app, const Globals& globals, Action& action);
void add_pdf(CLI::App& app, const Globals& globals, Action& action);
void add_sample(CLI::App& app, const Globals& globals, Action& action);
void add_generate(CLI::App& app, const Globals& globals, Action& action);
void add_albedo(CLI::App& app, const Globals& globals, Action& action);
void add_table(CLI::App& app, const Globals& globals, Action& action);
void add_plot(CLI::App& app, const Globals& globals, Action& action);
void add_render(CLI::App& app, const Globals& globals, Action& action);
void add_plan(CLI::App& app, const Globals& globals, Action& action);
void add_run_shard(CLI::App& app, const Globals& globals, Action& action);
void add_status(CLI::App& app, const Globals& globals, Action& action);
void add_merge(CLI::App& app, const Globals& globals, Action& action);
void add_report(CLI::App& app, const Globals& globals, Action& action);
void add_bench(CLI::App& app, const Globals& globals, Action& action);
/// Below bench.
void add_bench_sampling(CLI::App& bench, const Globals& globals, Action& action);
void add_bench_portability(CLI::App& bench, const Globals& globals, Action& action);
void add_bench_compare(CLI::App& bench, const Globals& globals, Action& action);
void add_tune(CLI::App& app, const Globals& globals, Action& action);

/// The positional arguments that several commands have.
inline void add_material(CLI::App& command, std::string& path) {
    command.add_option("MATERIAL", path, "material file (.json)")->required();
}
inline void add_directions(CLI::App& command, std::string& path) {
    command
        .add_option("DIRECTIONS", path,
                    ".csv with wi_x,wi_y,wi_z,wo_x,wo_y,wo_z or .npy of shape (N, 6)")
        ->required();
}
/// `--seed`: a whole number from 0, of 64 bits.
inline CLI::Option* add_seed(CLI::App& command, std::uint64_t& seed, const std::string& of) {
    return command.add_option("--seed", seed, of)->check([](const std::string& text) {
        return text.find_first_not_of("0123456789") == std::string::npos
                   ? std::string()
                   : text + ": expected a whole number from 0";
    });
}
/// The most directions one command makes: more would fill any disk.
inline constexpr std::uint64_t most_directions = 100000000;

/// Runs the program: parses the command line, runs the command, turns errors into messages.
/// Returns 0, 1 (bad input or failed job) or 2 (wrong usage).
int run(int argc, char** argv);

} // namespace brdfit::cli

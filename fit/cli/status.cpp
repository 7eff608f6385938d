#include "fit/runs/status.hpp"
#include "host/cli/command.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <thread>
#include <unistd.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string folder;
    bool watch = false, json = false;
};

int status(const Options& options) {
    const Plan plan = read_plan(options.folder);
    const bool terminal = isatty(STDOUT_FILENO) == 1;
    std::ptrdiff_t shown = 0; // lines, to be written over
    for (;;) {
        const RunStatus now = status_of(plan, options.folder);
        const std::string text =
            options.json ? dumped(to_json(now), options.watch ? -1 : 2) + "\n" : status_text(now);
        if (terminal && !options.json && shown > 0)
            fmt::print("\033[{}A\033[J", shown);
        fmt::print("{}", text);
        if (std::fflush(stdout) != 0 || !options.watch || now.counts.left == 0)
            return 0;
        shown = std::count(text.begin(), text.end(), '\n');
        std::this_thread::sleep_for(std::chrono::seconds(terminal ? 2 : 10));
    }
}

} // namespace

void add_status(CLI::App& app, const Globals&, Action& action) {
    CLI::App* command = app.add_subcommand("status", "How far a run is");
    auto options = std::make_shared<Options>();
    command->add_option("RUN", options->folder, "folder that brdfit plan wrote")->required();
    command->add_flag("--watch", options->watch, "say it again and again until nothing is left");
    command->add_flag("--json", options->json, "print it as JSON, with --watch one line a time");
    command->footer("Example:\n  brdfit status run --watch");
    command->callback([options, &action] { action = [options] { return status(*options); }; });
}

} // namespace brdfit::cli

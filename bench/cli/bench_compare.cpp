#include "bench/compare.hpp"
#include "host/cli/command.hpp"
#include "host/cli/within.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

using bench::Change;
using bench::Record;

struct Options {
    std::string before, after;
    double least = 5; // percent
    bool json = false;
};

std::string place(const Record::Row& row) {
    return fmt::format("{} of {}, {}, {} thread{}", row.work, row.model, row.device, row.threads,
                       row.threads == 1 ? "" : "s");
}

nlohmann::ordered_json to_json(const Change& change) {
    return {{"device", change.before.device},
            {"work", change.before.work},
            {"model", change.before.model},
            {"threads", change.before.threads},
            {"before", change.before.samples_per_second},
            {"after", change.after.samples_per_second},
            {"change", change.change()},
            {"noise", change.noise},
            {"verdict", change.slower()   ? "slower"
                        : change.faster() ? "faster"
                                          : "same"}};
}

int bench_compare(const Options& options) {
    const Record before = bench::read_record(options.before);
    const Record after = bench::read_record(options.after);
    bench::Comparison comparison = bench::compare(before, after, options.least / 100);
    if (before.machine != after.machine)
        spdlog::warn("measured on different machines: {} and {}", before.machine, after.machine);
    const auto slower = std::count_if(comparison.changes.begin(), comparison.changes.end(),
                                      [](const Change& c) { return c.slower(); });
    const auto faster = std::count_if(comparison.changes.begin(), comparison.changes.end(),
                                      [](const Change& c) { return c.faster(); });
    if (options.json) {
        nlohmann::ordered_json rows = nlohmann::ordered_json::array();
        for (const Change& change : comparison.changes)
            rows.push_back(to_json(change));
        fmt::print("{}\n", rows.dump(2));
        return slower > 0 ? 1 : 0;
    }
    std::stable_sort(comparison.changes.begin(), comparison.changes.end(),
                     [](const Change& a, const Change& b) { return a.change() < b.change(); });
    for (const Change& change : comparison.changes)
        if (change.slower() || change.faster())
            fmt::print("{} {:+6.1f}% (noise {:.1f}%): {}, {:.4g} M/s to {:.4g} M/s\n",
                       change.slower() ? "slower" : "faster", 100 * change.change(),
                       100 * change.noise, place(change.before),
                       change.before.samples_per_second / 1e6,
                       change.after.samples_per_second / 1e6);
    for (const Record::Row& row : comparison.gone)
        fmt::print("only in {}: {}\n", options.before, place(row));
    for (const Record::Row& row : comparison.added)
        fmt::print("only in {}: {}\n", options.after, place(row));
    fmt::print("{} slower, {} faster, {} the same within noise\n", slower, faster,
               static_cast<long>(comparison.changes.size()) - slower - faster);
    return slower > 0 ? 1 : 0;
}

} // namespace

void add_bench_compare(CLI::App& bench, const Globals&, Action& action) {
    CLI::App* command =
        bench.add_subcommand("compare", "Say what got slower between two runs, beyond their noise");
    auto options = std::make_shared<Options>();
    command->add_option("BEFORE", options->before, "what brdfit bench --json wrote")->required();
    command->add_option("AFTER", options->after, "the same, of a later run")->required();
    command
        ->add_option(
            "--least", options->least,
            "percent; changes below, or below the spreads of both runs together, are noise")
        ->check(within(0, 1000))
        ->capture_default_str();
    command->add_flag("--json", options->json, "print all rows as JSON");
    command->footer("Exit status: 0 nothing got slower, 1 something did (or a file is broken).\n"
                    "Example:\n  brdfit bench compare before.json after.json");
    command->callback(
        [options, &action] { action = [options] { return bench_compare(*options); }; });
}

} // namespace brdfit::cli

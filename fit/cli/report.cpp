#include "fit/jobs.hpp"
#include "fit/report/page.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string folder, out;
    Selection selection;
    ReportOptions report;
    bool force = false, samples_given = false;
};

int report(Options options, const Globals& globals) {
    const std::string ending = std::filesystem::path(options.out).extension().string();
    if (ending != ".html" && ending != ".htm")
        throw UsageError(fmt::format("{}: unknown ending; expected .html", options.out));
    if (options.samples_given && options.report.size == 0)
        throw UsageError("--samples: changes nothing with --size 0; expected pictures");
    if (!options.force)
        check_none_is_there({options.out});
    OutputFile file(options.out); // a path that cannot be written costs no time
    Results results;
    {
        Progress progress(1, globals.quiet);
        results =
            read_results(options.folder, options.selection, progress.step(0, "reading the fits"));
    }
    for (const std::string& note : results.notes)
        spdlog::warn("{}", note);
    Progress progress(results.materials.size(), globals.quiet);
    options.report.next = [&](const std::string& material, std::size_t done) {
        progress.show(done, material);
    };
    const std::string page =
        report_page(results, options.report, [&] { return open_device(globals.device); });
    progress.clear();
    file.write(page);
    file.commit();
    fmt::print("{}: {} fits, {} failed; materials: {}; {:.1f} MB\n", options.out,
               results.fits.size(), results.failures.size(), results.materials.size(),
               static_cast<double>(page.size()) / 1e6);
    return 0;
}

} // namespace

void add_report(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "report", "One page of a run's results, with pictures, that needs no other file");
    auto options = std::make_shared<Options>();
    command
        ->add_option("RUN|FOLDER", options->folder,
                     "folder of a run, or one that brdfit fit wrote materials to")
        ->required();
    command->add_option("-o,--output", options->out, ".html")->required();
    command
        ->add_option("--materials", options->selection.materials,
                     "names of materials to show, with * and ?; several with commas between")
        ->allow_extra_args(false)
        ->delimiter(',');
    command
        ->add_option("--models", options->selection.models,
                     "models to show; several with commas between")
        ->allow_extra_args(false)
        ->delimiter(',');
    command->add_option("--metric", options->selection.metric,
                        "show the fits that minimise it (default: the first of the run)");
    command->add_option("--model", options->report.model,
                        "MODEL or MODEL:LOBES to set beside each material's best fit (default: "
                        "the one of the fewest lobes with the least mean error)");
    command
        ->add_option("--size", options->report.size, "of the pictures, pixels; 0: none, nor plots")
        ->capture_default_str()
        ->check(CLI::Range(std::size_t{0}, most_report_size));
    CLI::Option* const samples =
        command->add_option("--samples", options->report.samples, "of the pictures, a pixel")
            ->capture_default_str()
            ->check(CLI::Range(1, 65536));
    command->add_flag("--force", options->force, "replace a page that is there");
    command->footer("Example:\n  brdfit report run -o report.html");
    command->callback([options, samples, &globals, &action] {
        options->samples_given = samples->count() > 0;
        action = [options, &globals] { return report(*options, globals); };
    });
}

} // namespace brdfit::cli

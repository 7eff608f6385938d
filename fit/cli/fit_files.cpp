#include "fit/cli/fit_files.hpp"

#include "fit/programs.hpp"
#include "fit/report.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

// Throws InputError where a file cannot be made in the folder, before any work is done.
void check_folder(const std::string& folder) {
    make_output_folder(folder);
    OutputFile probe((std::filesystem::path(folder) / ".brdfit").string());
}

void report_speed(const FitResult& r) {
    spdlog::debug("{} {}: build {:.3f} s, search {:.3f} s ({} thinned evaluations), polish {:.3f} "
                  "s ({} passes over {} "
                  "samples, {:.0f} million samples/s)",
                  r.model, r.material.lobes.size(), r.build_seconds, r.search_seconds,
                  r.thinned_evaluations, r.polish_seconds, r.passes, r.samples,
                  r.samples_per_second() / 1e6);
    if (r.random_starts_better > 0)
        spdlog::warn("{} {}: {} random starts beat the global search", r.model,
                     r.material.lobes.size(), r.random_starts_better);
}

} // namespace

int fit_files(const FitRequest& request, const FitSummaries& summaries, const Globals& globals) {
    const Device device = open_device(globals.device);
    spdlog::debug("device {}: {}", device.index, device.name);
    const bool folder_is_new = !std::filesystem::exists(request.folder);
    check_folder(request.folder);
    ProgramCache programs(device);
    const std::vector<std::string> stems = distinct_stems(request.files);
    std::vector<FitRow> rows;
    bool failed = false;
    const std::size_t jobs_a_file = structures_of(request, true).size();
    Progress progress(request.files.size() * jobs_a_file, globals.quiet);
    for (std::size_t f = 0; f < request.files.size(); ++f) {
        const std::string& file = request.files[f];
        const std::size_t first_row = rows.size();
        try {
            progress.show(f * jobs_a_file, file);
            const Samples samples = read_samples(file, request.isotropic);
            FileFitter fitter(device, programs, samples, request.options);
            const std::vector<Structure> structures = structures_of(request, samples.isotropic);
            for (std::size_t s = 0; s < structures.size(); ++s) {
                progress.show(f * jobs_a_file + s,
                              fmt::format("{} {}", stems[f], structures[s].name()));
                FitRow row{file, {}, fitter.fit(structures[s])};
                FitResult& result = row.result;
                result.material.fit = fit_record(result, samples, request.options, device);
                row.material_file = (std::filesystem::path(request.folder) /
                                     fmt::format("{}.{}.{}.json", stems[f], result.model,
                                                 result.material.lobes.size()))
                                        .string();
                write_material(result.material, row.material_file);
                progress.clear();
                report_speed(result);
                rows.push_back(std::move(row));
            }
        } catch (const UsageError&) {
            throw;
        } catch (const std::exception& error) {
            progress.clear();
            spdlog::error("{}", error.what());
            failed = true;
        }
        if (!summaries.json && rows.size() > first_row) {
            progress.clear();
            std::vector<const FitRow*> of_file;
            for (std::size_t i = first_row; i < rows.size(); ++i)
                of_file.push_back(&rows[i]);
            fmt::print("{}: {} samples fitted\n{}\n", file, of_file.front()->result.samples,
                       fit_table(of_file, request.options.metric));
            std::fflush(stdout);
        }
    }
    progress.clear();
    if (summaries.json)
        fmt::print("{}\n", fit_rows_json(rows, request.options).dump(2));
    if (!summaries.csv.empty() && !rows.empty())
        write_fit_csv(rows, request.options, summaries.csv);
    if (rows.empty() && folder_is_new) {
        std::error_code ignored; // it is not empty any more, then
        std::filesystem::remove(request.folder, ignored);
    }
    return failed ? 1 : 0;
}

} // namespace brdfit::cli

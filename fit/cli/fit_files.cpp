#include "fit/cli/fit_files.hpp"

#include "fit/programs.hpp"
#include "fit/report.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/device/errors.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <optional>
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
}

// The message, with the file in front where it does not name it.
std::string message_naming(const std::string& file, const std::exception& error) {
    const std::string message = message_of(error);
    return message.find(file) == std::string::npos ? fmt::format("{}: {}", file, message) : message;
}

// Fits all structures asked for to one file; what fails is reported and noted.
void fit_file(const FitRequest& request, const Device& device, ProgramCache& programs,
              const std::string& file, const std::string& stem,
              const std::function<ProgressFunction(const std::string& next)>& next,
              Progress& progress, FitRows& rows) {
    std::optional<Samples> samples;
    std::optional<FileFitter> fitter;
    const auto failed = [&](const std::string& model, std::size_t lobes, const std::string& why) {
        progress.clear();
        spdlog::error("{}",
                      model.empty() ? why : fmt::format("{}: {} {}: {}", file, model, lobes, why));
        rows.failed.push_back({file, model, lobes, why});
    };
    try {
        samples.emplace(read_measurement(file, request.isotropic));
        fitter.emplace(device, programs, *samples, request.options);
    } catch (const UsageError&) {
        throw;
    } catch (const std::exception& error) {
        failed("", 0, message_naming(file, error));
        return;
    }
    if (request.orient && samples->isotropic) {
        progress.clear();
        spdlog::warn("{}: is isotropic, so that --orient has nothing to turn", file);
    }
    const std::vector<Structure> structures = structures_of(request, samples->isotropic);
    std::vector<std::optional<FitRow>> fitted(structures.size());
    const auto done = [&](FitOutcome outcome) {
        const Structure& structure = structures[outcome.index];
        try {
            if (outcome.failure)
                std::rethrow_exception(outcome.failure);
            FitRow row{file, material_path(request, stem, structure), std::move(*outcome.result)};
            row.result.material.fit = fit_record(row.result, *samples, request.options, device);
            write_material(row.result.material, row.material_file);
            progress.clear();
            report_speed(row.result);
            fitted[outcome.index] = std::move(row);
        } catch (const UsageError&) {
            throw;
        } catch (const std::exception& error) {
            failed(structure.name(), structure.lobes.size(), message_of(error));
        }
    };
    fitter->fit_all(
        structures, fits_at_once(device),
        [&](std::size_t i) {
            return next(
                fmt::format("{} {} {}", stem, structures[i].name(), structures[i].lobes.size()));
        },
        done);
    for (std::optional<FitRow>& row : fitted)
        if (row)
            rows.done.push_back(std::move(*row));
}

} // namespace

int fit_files(const FitRequest& request, bool json, const Globals& globals) {
    check_nothing_is_replaced(request);
    const Device device = open_device(globals.device);
    spdlog::debug("device {}: {}", device.index, device.name);
    std::error_code unknown; // said by check_folder
    const bool folder_is_new = !std::filesystem::exists(request.folder, unknown);
    check_folder(request.folder);
    ProgramCache programs(device);
    const std::vector<std::string> stems = distinct_stems(request.files);
    FitRows rows;
    const std::size_t fits_a_file = structures_of(request, true).size();
    Progress progress(request.files.size() * fits_a_file, globals.quiet);
    for (std::size_t f = 0; f < request.files.size(); ++f) {
        const std::string& file = request.files[f];
        const std::size_t first_row = rows.done.size();
        std::size_t done = f * fits_a_file;
        progress.show(done, file);
        fit_file(
            request, device, programs, file, stems[f],
            [&](const std::string& next) { return progress.step(done++, next); }, progress, rows);
        if (!json && rows.done.size() > first_row) {
            progress.clear();
            std::vector<const FitRow*> of_file;
            for (std::size_t i = first_row; i < rows.done.size(); ++i)
                of_file.push_back(&rows.done[i]);
            fmt::print("{}: {} samples fitted\n{}\n", file, of_file.front()->result.samples,
                       fit_table(of_file, request.options.metric));
            std::fflush(stdout);
        }
    }
    progress.clear();
    if (json)
        fmt::print("{}\n", dumped(fit_rows_json(rows, request.options), 2));
    if (!request.csv.empty())
        write_fit_csv(rows, request.options, request.csv);
    if (rows.done.empty() && folder_is_new) {
        std::error_code ignored; // it is not empty any more, then
        std::filesystem::remove(request.folder, ignored);
    }
    return rows.failed.empty() ? 0 : 1;
}

} // namespace brdfit::cli

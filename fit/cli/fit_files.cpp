#include "fit/cli/fit_files.hpp"

#include "fit/fit_all.hpp"
#include "fit/report.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/device/errors.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <future>
#include <optional>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

// Throws InputError where a file cannot be made in the folder, before any work is done.
void check_folder(const std::string& folder) {
    make_output_folder(folder);
    OutputFile probe((std::filesystem::path(folder) / ".brdfit").string());
}

void report_speed(const FitResult& r, const Device& device) {
    spdlog::debug("{} {} on device {}: build {:.3f} s, search {:.3f} s ({} thinned evaluations), "
                  "polish {:.3f} "
                  "s ({} passes over {} "
                  "samples, {:.0f} million samples/s)",
                  r.model, r.material.lobes.size(), device.index, r.build_seconds, r.search_seconds,
                  r.thinned_evaluations, r.polish_seconds, r.passes, r.samples,
                  r.samples_per_second() / 1e6);
}

// The message, with the file in front where it does not name it.
std::string message_naming(const std::string& file, const std::exception& error) {
    const std::string message = message_of(error);
    return message.find(file) == std::string::npos ? fmt::format("{}: {}", file, message) : message;
}

// The programs of the first fit are built while its file is read, where a look at the file tells
// which they are.
void build_ahead(const FitRequest& request, ProgramCache& programs) noexcept {
    constexpr int channels = 3;
    try {
        if (request.isotropic != false &&
            merl::recognise(MappedFile(request.files.front()).bytes()))
            programs.build_ahead(structures_of(request, true).front(), channels, channels);
    } catch (const std::exception&) { // whoever reads the file says what
    }
}

// Fits all structures asked for to one file, after `before` fits to others; what fails is reported
// and noted.
void fit_file(const FitRequest& request, FitDevices& devices, const std::string& file,
              const std::string& stem, const std::function<Samples()>& read, std::size_t before,
              Progress& progress, FitRows& rows) {
    std::optional<Samples> samples;
    const auto failed = [&](const std::string& model, std::size_t lobes, const std::string& why) {
        progress.clear();
        spdlog::error("{}",
                      model.empty() ? why : fmt::format("{}: {} {}: {}", file, model, lobes, why));
        rows.failed.push_back({file, model, lobes, why});
    };
    std::vector<Structure> structures;
    std::vector<std::optional<FitRow>> fitted;
    std::size_t ended = before;
    const auto next = [&](std::size_t i) {
        return progress.step(
            ended, fmt::format("{} {} {}", stem, structures[i].name(), structures[i].lobes.size()));
    };
    const auto done = [&](FitOutcome outcome) {
        const Structure& structure = structures[outcome.index];
        ++ended;
        try {
            if (outcome.failure)
                std::rethrow_exception(outcome.failure);
            FitRow row{file, material_path(request, stem, structure), std::move(*outcome.result)};
            row.result.material.fit =
                fit_record(row.result, *samples, request.options, *outcome.device);
            write_material(row.result.material, row.material_file);
            progress.clear();
            report_speed(row.result, *outcome.device);
            fitted[outcome.index] = std::move(row);
        } catch (const UsageError&) {
            throw;
        } catch (const std::exception& error) {
            failed(structure.name(), structure.lobes.size(), message_of(error));
        }
    };
    try {
        samples.emplace(read());
        if (request.orient && samples->isotropic) {
            progress.clear();
            spdlog::warn("{}: is isotropic, so that --orient has nothing to turn", file);
        }
        structures = structures_of(request, samples->isotropic);
        fitted.resize(structures.size());
        if (const std::exception_ptr hindrance =
                fit_all(devices, *samples, request.options, structures, {}, {next, done, {}}))
            std::rethrow_exception(hindrance);
    } catch (const UsageError&) {
        throw;
    } catch (const std::exception& error) {
        failed("", 0, message_naming(file, error));
    }
    for (std::optional<FitRow>& row : fitted)
        if (row)
            rows.done.push_back(std::move(*row));
}

} // namespace

int fit_files(const FitRequest& request, bool json, const Globals& globals) {
    check_nothing_is_replaced(request);
    const auto read = [&](const std::string& file) {
        return read_measurement(file, request.isotropic);
    };
    // Opening a device takes as long as a third of a fit.
    std::future<Samples> first = std::async(read, request.files.front());
    FitDevices devices(open_devices(globals.device));
    for (std::size_t d = 0; d < devices.size(); ++d)
        spdlog::debug("device {}: {}", devices[d].device.index, devices[d].device.name);
    std::error_code unknown; // said by check_folder
    const bool folder_is_new = !std::filesystem::exists(request.folder, unknown);
    check_folder(request.folder);
    const std::future<void> ahead = std::async([&] { build_ahead(request, devices[0].programs); });
    const std::vector<std::string> stems = distinct_stems(request.files);
    FitRows rows;
    const std::size_t fits_a_file = structures_of(request, true).size();
    Progress progress(request.files.size() * fits_a_file, globals.quiet);
    for (std::size_t f = 0; f < request.files.size(); ++f) {
        const std::string& file = request.files[f];
        const std::size_t first_row = rows.done.size();
        progress.show(f * fits_a_file, file);
        fit_file(
            request, devices, file, stems[f], [&] { return f == 0 ? first.get() : read(file); },
            f * fits_a_file, progress, rows);
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

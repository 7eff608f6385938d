#include "host/cli/fit_files.hpp"

#include "fit/report.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/file.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

// The structures asked for, each once, fewer lobes first.
std::vector<Structure> structures_of(const FitRequest& request, bool isotropic) {
    std::vector<std::string> names;
    for (const std::string& name : request.models) {
        if (name != "all") {
            names.push_back(name);
            continue;
        }
        for (const Model& model : catalogue())
            if (model.listed())
                names.push_back(model.name);
    }
    std::vector<int> counts = request.lobes;
    std::sort(counts.begin(), counts.end());
    std::vector<Structure> structures;
    std::set<std::string> known;
    for (const int count : counts)
        for (const std::string& name : names) {
            // `all` leaves out what the diffuse shape asked for cannot go with.
            const bool from_all = std::find(request.models.begin(), request.models.end(), name) ==
                                  request.models.end();
            try {
                const Structure structure =
                    structure_named(name, count, request.diffuse, isotropic);
                if (known.insert(structure.key()).second)
                    structures.push_back(structure);
            } catch (const UsageError&) {
                if (!from_all)
                    throw;
            }
        }
    if (structures.empty())
        throw UsageError("no model goes with the diffuse shape asked for");
    return structures;
}

// A stem for each file's materials; equal stems get numbers.
std::vector<std::string> distinct_stems(const std::vector<std::string>& files) {
    std::set<std::string> taken;
    std::vector<std::string> stems;
    for (const std::string& file : files) {
        const std::string stem = std::filesystem::path(file).stem().string();
        std::string name = stem;
        for (int i = 2; !taken.insert(name).second; ++i)
            name = fmt::format("{}-{}", stem, i);
        stems.push_back(name);
    }
    return stems;
}

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

void check(const FitRequest& request) {
    for (const bool isotropic : {true, false}) {
        if (request.isotropic && *request.isotropic != isotropic)
            continue;
        const std::vector<Structure> structures = structures_of(request, isotropic);
        for (const Structure& structure : structures)
            Space(structure.lobes, isotropic, request.options.ranges); // throws on contradictions
        for (const ParameterRange& range : request.options.ranges) {
            const auto means_one_of = [&](const Structure& structure) {
                std::vector<const Model*> lobes = structure.lobes;
                const auto lobe = static_cast<std::size_t>(range.lobe);
                if (lobe > 0)
                    lobes = lobe > lobes.size() ? std::vector<const Model*>{}
                                                : std::vector<const Model*>{lobes[lobe - 1]};
                return names_parameter_of(range, lobes);
            };
            if (std::none_of(structures.begin(), structures.end(), means_one_of))
                throw UsageError(
                    range.lobe == 0
                        ? fmt::format("no model asked for has a parameter '{}'", range.name)
                        : fmt::format("no fit asked for has a parameter '{}.{}'", range.lobe,
                                      range.name));
        }
    }
}

int fit_files(const FitRequest& request, const Globals& globals) {
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
        if (!request.json && rows.size() > first_row) {
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
    if (request.json)
        fmt::print("{}\n", fit_rows_json(rows, request.options).dump(2));
    if (!request.csv.empty() && !rows.empty())
        write_fit_csv(rows, request.options, request.csv);
    if (rows.empty() && folder_is_new) {
        std::error_code ignored; // it is not empty any more, then
        std::filesystem::remove(request.folder, ignored);
    }
    return failed ? 1 : 0;
}

} // namespace brdfit::cli

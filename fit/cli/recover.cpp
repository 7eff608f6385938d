#include "fit/cli/recover.hpp"

#include "fit/fit.hpp"
#include "fit/metric.hpp"
#include "fit/programs.hpp"
#include "fit/recover.hpp"
#include "fit/report.hpp"
#include "fit/structures.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/files/json.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

// The structures to compare with, of one lobe.
std::vector<Structure> structures_of(const RecoverRequest& request, bool isotropic) {
    std::vector<std::string> models = request.models;
    models.erase(std::remove(models.begin(), models.end(), "none"), models.end());
    return models.empty() ? std::vector<Structure>{} : structures_named(models, {1}, "", isotropic);
}

// The material of what was recovered, beside its table.
Material material_of(const Recovered& recovered, const Samples& samples, const std::string& out) {
    Material material;
    material.channels = samples.channels;
    material.diffuse = &model_named("lambert");
    material.kd = recovered.kd;
    Lobe lobe;
    lobe.model = &model_named("microfacet");
    lobe.theta = {recovered.f0};
    lobe.ks = recovered.ks;
    lobe.table = std::make_shared<MicrofacetTable>(recovered.table);
    lobe.table_file = std::filesystem::path(out).filename().string();
    material.lobes = {lobe};
    return material;
}

} // namespace

void add_recover_options(CLI::App& command, RecoverRequest& request) {
    command
        .add_option("-m,--model", request.models,
                    "with --from: models to compare with, with commas between; all, or none")
        ->allow_extra_args(false)
        ->delimiter(',');
    command
        .add_option("--max-theta", request.max_theta,
                    "with --from: drop samples beyond this angle from the normal, degrees")
        ->check(within(1, 90))
        ->capture_default_str();
    command.add_flag("--force", request.force, "with --from: replace a material beside the table");
    request.isotropy.add_to(command);
}

int recover_from(const RecoverRequest& request, const GeneratorOptions& options,
                 const Generator& generator, const Device& device, const std::string& out,
                 bool json, const Globals& globals) {
    for (const bool isotropic : {true, false})
        structures_of(request, isotropic); // unknown names first
    const std::string material_file =
        std::filesystem::path(out).replace_extension(".json").string();
    if (std::error_code unknown; !request.force && std::filesystem::exists(material_file, unknown))
        throw InputError(fmt::format("{} is there already, where the material of {} goes; --force "
                                     "replaces it, or choose another name",
                                     material_file, out));
    const Samples samples = read_measurement(request.file, request.isotropy.choice());
    const std::vector<Structure> structures = structures_of(request, samples.isotropic);
    Progress progress(structures.size() + 1, globals.quiet);
    const auto begin = std::chrono::steady_clock::now();
    RecoverOptions recover_options;
    recover_options.max_theta = request.max_theta;
    recover_options.generator = options;
    recover_options.progress = progress.step(0, "recovering the distribution");
    const Recovered recovered = recover(device, generator, samples, recover_options);

    FitOptions fit_options;
    fit_options.max_theta = request.max_theta;
    FitRow own;
    own.file = request.file;
    own.material_file = material_file;
    own.result.model = "microfacet";
    own.result.material = material_of(recovered, samples, out);
    const DeviceSamples packed = pack_samples(device, samples, request.max_theta, Metric::Ngan);
    const std::vector<float> values = evaluate(device, own.result.material, *samples.directions);
    own.result.errors = value_errors(samples, packed.used, values);
    own.outside_peak = error_outside_peak(samples, packed.used, values);
    own.result.theta = {recovered.f0};
    own.result.samples = recovered.samples;
    own.result.evaluations = static_cast<std::size_t>(recovered.evaluations);
    own.result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    own.result.material.fit = fit_record(own.result, samples, fit_options, device);
    own.result.material.fit["algorithm"] = "LD_LBFGS";
    write_table(recovered.table, out);
    write_material(own.result.material, own.material_file);

    FitRows rows;
    rows.done.push_back(own);
    ProgramCache programs(device);
    FileFitter fitter(device, programs, samples, fit_options);
    for (std::size_t s = 0; s < structures.size(); ++s) {
        progress.show(1 + s, structures[s].name());
        FitRow row{request.file, "", fitter.fit(structures[s])};
        row.outside_peak = error_outside_peak(
            samples, packed.used, evaluate(device, row.result.material, *samples.directions));
        rows.done.push_back(std::move(row));
    }
    progress.clear();
    if (json) {
        fmt::print("{}\n", dumped(fit_rows_json(rows, fit_options), 2));
        return 0;
    }
    std::vector<const FitRow*> of_file;
    for (const FitRow& row : rows.done)
        of_file.push_back(&row);
    fmt::print("{}: {} samples, {} polar angles of normals{}, {} evaluations, material {}\n{}",
               request.file, recovered.samples, recovered.table.distribution.parts[0].table->height,
               samples.isotropic ? ""
                                 : fmt::format(" and {} azimuths",
                                               recovered.table.distribution.parts[0].table->width),
               recovered.evaluations, own.material_file, fit_table(of_file, Metric::Ngan));
    return 0;
}

} // namespace brdfit::cli

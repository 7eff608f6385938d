#include "fit/report/results.hpp"

#include "fit/report/folder.hpp"
#include "fit/runs/merge.hpp"
#include "fit/runs/status.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fnmatch.h>
#include <set>

namespace brdfit {

namespace {

namespace fs = std::filesystem;

std::string text_of(const Json& value) {
    if (value.is_string())
        return value.get<std::string>();
    if (value.is_boolean())
        return value.get<bool>() ? "yes" : "no";
    if (!value.is_array())
        return dumped(value);
    std::string text;
    for (const Json& element : value)
        text += (text.empty() ? "" : ", ") + text_of(element);
    return text;
}

Results results_of_run(const std::string& folder, const std::string& metric,
                       const ProgressFunction& progress) {
    const Plan plan = read_plan(folder);
    Results results;
    results.metric = metric.empty() ? plan.metrics.front() : metric_named(metric);
    if (std::find(plan.metrics.begin(), plan.metrics.end(), results.metric) == plan.metrics.end())
        throw UsageError(fmt::format("--metric {}: no fit of the run minimises it; expected {}",
                                     metric, text_of(settings_json(plan).at("metric"))));
    std::vector<std::string> paths;
    for (const PlannedFile& file : plan.files)
        paths.push_back(file.path);
    const std::vector<std::string> names = distinct_stems(paths);
    for (std::size_t f = 0; f < plan.files.size(); ++f) {
        const PlannedFile& file = plan.files[f];
        results.materials.push_back({names[f], file.path, plan.path_of(file), file.sha256});
    }
    const auto done = [&](FitRow row, const Task& task) {
        if (task.metric != results.metric)
            return;
        row.result.material.fit = nullptr; // read, and large
        results.fits.push_back({task.file, std::move(row.result), task.metric});
    };
    const auto failed = [&](FailedFit fit, const Task& task) {
        if (task.metric == results.metric)
            results.failures.push_back({task.file, fit.model, fit.lobes, fit.reason});
    };
    const MergeReport report = read_rows(plan, folder, {done, failed}, progress);
    results.settings = {{"run", fs::absolute(folder).lexically_normal().filename().string()},
                        {"fits", fmt::format("{} done, {} failed, {} left", report.done,
                                             report.failed, report.left)}};
    const Json settings = settings_json(plan);
    for (const auto& [key, value] : settings.items())
        if (!value.is_null() && !(value.is_array() && value.empty()) && value != "")
            results.settings.emplace_back(key, text_of(value));
    for (const auto& [maker, fits] : report.made_by)
        results.settings.emplace_back("device", fmt::format("{} ({} fits)", maker, fits));
    if (!report.broken.empty())
        results.notes.push_back(broken_text(report.broken));
    if (report.left > 0)
        results.notes.push_back(fmt::format("{} fits of the plan are not done yet.", report.left));
    if (plan.metrics.size() > 1)
        results.notes.push_back(
            fmt::format("The run has fits by other metrics too; these minimise {} (--metric).",
                        name_of(results.metric)));
    return results;
}

/// Throws UsageError for a name that none has.
void require_known(const std::string& option, const std::vector<std::string>& wanted,
                   const std::set<std::string>& names) {
    constexpr std::size_t most_named = 20;
    for (const std::string& pattern : wanted) {
        const bool known = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
            return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
        });
        if (known)
            continue;
        std::vector<std::string> some(names.begin(), names.end());
        const std::size_t more = some.size() - std::min(some.size(), most_named);
        some.resize(some.size() - more);
        throw UsageError(fmt::format("{} {}: there is none; expected {}{}", option, pattern,
                                     fmt::join(some, ", "),
                                     more > 0 ? fmt::format(" or one of {} more", more) : ""));
    }
}

bool selected(const std::vector<std::string>& wanted, const std::string& name) {
    return wanted.empty() ||
           std::any_of(wanted.begin(), wanted.end(), [&](const std::string& pattern) {
               return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
           });
}

/// Leaves what is selected.
void restrict(Results& results, const Selection& selection) {
    std::set<std::string> materials, models;
    for (const ReportedMaterial& material : results.materials)
        materials.insert(material.name);
    for (const ReportedFit& fit : results.fits)
        models.insert(fit.result.model);
    for (const ReportedFailure& failure : results.failures)
        if (!failure.model.empty())
            models.insert(failure.model);
    require_known("--materials", selection.materials, materials);
    require_known("--models", selection.models, models);
    std::vector<std::size_t> place(results.materials.size());
    std::vector<ReportedMaterial> kept;
    for (std::size_t m = 0; m < place.size(); ++m) {
        place[m] = kept.size();
        if (selected(selection.materials, results.materials[m].name))
            kept.push_back(results.materials[m]);
        else
            place[m] = results.materials.size(); // none
    }
    const auto drop = [&](const auto& of, const std::string& model) {
        return place[of.material] == results.materials.size() ||
               (!model.empty() && !selected(selection.models, model));
    };
    auto& fits = results.fits;
    fits.erase(std::remove_if(fits.begin(), fits.end(),
                              [&](const ReportedFit& fit) { return drop(fit, fit.result.model); }),
               fits.end());
    auto& failures = results.failures;
    failures.erase(std::remove_if(failures.begin(), failures.end(),
                                  [&](const ReportedFailure& failure) {
                                      return drop(failure, failure.model);
                                  }),
                   failures.end());
    for (ReportedFit& fit : fits)
        fit.material = place[fit.material];
    for (ReportedFailure& failure : failures)
        failure.material = place[failure.material];
    if (kept.size() < results.materials.size())
        results.settings.emplace_back("shown materials",
                                      fmt::format("{} of {}", kept.size(), place.size()));
    if (!selection.models.empty())
        results.settings.emplace_back("shown models",
                                      fmt::format("{}", fmt::join(selection.models, ", ")));
    results.materials = std::move(kept);
}

} // namespace

std::string ReportedFit::name() const {
    return lobes() == 0
               ? result.model
               : fmt::format("{}, {} lobe{}", result.model, lobes(), lobes() == 1 ? "" : "s");
}

Results read_results(const std::string& folder, const Selection& selection,
                     const ProgressFunction& progress) {
    std::error_code unknown;
    const bool is_run = fs::exists(fs::path(folder) / "plan.json", unknown);
    Results results = is_run ? results_of_run(folder, selection.metric, progress)
                             : results_of_fits(folder, selection.metric, progress);
    restrict(results, selection);
    return results;
}

} // namespace brdfit

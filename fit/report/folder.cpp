#include "fit/report/folder.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"
#include "host/measured/kind.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <optional>
#include <set>

namespace brdfit {

namespace {

namespace fs = std::filesystem;

/// The files of a folder with an ending, in the order of their names.
std::vector<std::string> files_in(const std::string& folder, const char* ending) {
    std::vector<std::string> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error))
        if (entry->path().extension() == ending)
            files.push_back(entry->path().string());
    if (error)
        throw InputError(fmt::format("{}: cannot read the folder: {}", folder, error.message()));
    std::sort(files.begin(), files.end());
    return files;
}

/// The rows of a CSV text whose fields may be quoted.
std::vector<std::vector<std::string>> csv_rows(std::string_view text) {
    std::vector<std::vector<std::string>> rows(1, {""});
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted && c == '"' && text.substr(i + 1, 1) == "\"")
            rows.back().back() += text[++i];
        else if (c == '"')
            quoted = !quoted;
        else if (quoted || (c != ',' && c != '\n'))
            rows.back().back() += c;
        else if (c == ',')
            rows.back().emplace_back();
        else
            rows.push_back({""});
    }
    return rows;
}

constexpr std::string_view summary_begins = "file,model,lobes,metric,";

/// Fits read one by one into results.
class Folder {
  public:
    Folder(std::string folder, std::string metric)
        : folder_(std::move(folder)), metric_(std::move(metric)) {}

    void add_material(const std::string& path) {
        if (recognised(MappedFile(path)).kind != FileKind::Material) {
            results_.notes.push_back(fmt::format("{} is no material, and left out.", path));
            return;
        }
        Material material = read_material(path);
        if (material.fit.is_null() || !material.fit.contains("error"))
            return; // none that was fitted
        try {
            const Json record = material.fit;
            const Metric metric = metric_named(record.at("metric").get<std::string>());
            const auto source = record.at("source").get<std::string>();
            ReportedFit fit{0, recorded_fit(std::move(material)), metric};
            fit.result.material.fit = nullptr;
            fit.material = material_of(source, record.value("sha256", ""), stem_of(path, fit));
            found_.push_back(std::move(fit));
            ++metrics_[metric];
            note_settings(record);
        } catch (const UsageError& error) { // the metric
            throw InputError(fmt::format("{}: fit.metric: {}", path, error.what()));
        } catch (const Json::exception& error) {
            throw InputError(fmt::format("{}: fit: is no record of a fit: {}", path, error.what()));
        } catch (const std::logic_error&) {
            throw InputError(fmt::format("{}: fit: is no record of a fit", path));
        }
    }

    void add_summary(const std::string& path) {
        const MappedFile file(path);
        if (file.bytes().substr(0, summary_begins.size()) != summary_begins)
            return; // another table
        const std::vector<std::vector<std::string>> rows = csv_rows(file.bytes());
        const auto head = rows.front();
        const auto failed =
            static_cast<std::size_t>(std::find(head.begin(), head.end(), "failed") - head.begin());
        for (std::size_t r = 1; r < rows.size(); ++r) {
            const std::vector<std::string>& row = rows[r];
            if (row.size() <= failed || row[failed].empty())
                continue;
            ReportedFailure failure{material_of(row[0], "", fs::path(row[0]).stem().string()),
                                    row[1], 0, row[failed]};
            std::from_chars(row[2].data(), row[2].data() + row[2].size(), failure.lobes);
            results_.failures.push_back(std::move(failure));
        }
    }

    Results results() {
        if (found_.empty() && results_.failures.empty())
            throw InputError(fmt::format("{}: has neither plan.json nor fitted materials; expected "
                                         "a folder that plan and run, or fit, wrote",
                                         folder_));
        choose_metric();
        results_.settings.emplace_back(
            "folder", fs::absolute(folder_).lexically_normal().filename().string());
        for (const auto& [key, values] : settings_)
            results_.settings.emplace_back(key, fmt::format("{}", fmt::join(values, "; ")));
        return std::move(results_);
    }

  private:
    /// The name of a fit's file without model and lobes.
    static std::string stem_of(const std::string& path, const ReportedFit& fit) {
        std::string stem = fs::path(path).stem().string();
        const std::string ending = fmt::format(".{}.{}", fit.result.model, fit.lobes());
        if (stem.size() > ending.size() &&
            stem.compare(stem.size() - ending.size(), ending.size(), ending) == 0)
            stem.resize(stem.size() - ending.size());
        return stem;
    }

    std::size_t material_of(const std::string& source, const std::string& sha256,
                            const std::string& name) {
        const auto [known, fresh] = places_.emplace(source, results_.materials.size());
        if (fresh) {
            std::string distinct = name;
            for (int i = 2; !names_.insert(distinct).second; ++i)
                distinct = fmt::format("{}-{}", name, i);
            results_.materials.push_back({distinct, source, source, sha256});
        }
        return known->second;
    }

    void note_settings(const Json& record) {
        for (const char* key : {"metric", "max_theta", "algorithm", "max_evaluations", "starts",
                                "seed", "ranges", "conserve", "device", "version"})
            if (const Json* value = optional(record, key);
                value != nullptr && *value != Json::array())
                settings_[key].insert(value->is_string() ? value->get<std::string>()
                                                         : dumped(*value));
    }

    void choose_metric() {
        std::vector<std::string> names;
        for (const auto& [metric, fits] : metrics_)
            names.emplace_back(name_of(metric));
        results_.metric = !metric_.empty()   ? metric_named(metric_)
                          : metrics_.empty() ? Metric::Ngan
                                             : metrics_.begin()->first;
        if (!metric_.empty() && metrics_.count(results_.metric) == 0)
            throw UsageError(
                fmt::format("--metric {}: no fit of the folder minimises it; expected {}", metric_,
                            fmt::join(names, ", ")));
        if (metrics_.size() > 1)
            results_.notes.push_back(
                fmt::format("The folder has fits by several metrics ({}); these minimise {} "
                            "(--metric).",
                            fmt::join(names, ", "), name_of(results_.metric)));
        for (ReportedFit& fit : found_)
            if (fit.metric == results_.metric)
                results_.fits.push_back(std::move(fit));
    }

    std::string folder_, metric_;
    Results results_;
    std::vector<ReportedFit> found_;
    std::map<Metric, std::size_t> metrics_;
    std::map<std::string, std::size_t> places_; // of materials, by source
    std::set<std::string> names_;
    std::map<std::string, std::set<std::string>> settings_;
};

} // namespace

Results results_of_fits(const std::string& folder, const std::string& metric,
                        const ProgressFunction& progress) {
    Folder found(folder, metric);
    const std::vector<std::string> materials = files_in(folder, ".json");
    for (std::size_t i = 0; i < materials.size(); ++i) {
        tell(progress, static_cast<double>(i) / static_cast<double>(materials.size()));
        found.add_material(materials[i]);
    }
    for (const std::string& path : files_in(folder, ".csv"))
        found.add_summary(path);
    return found.results();
}

} // namespace brdfit

#include "fit/report.hpp"

#include "host/files/file.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

double minimised_error(const FitRow& row, Metric metric) {
    return row.result.errors[static_cast<std::size_t>(metric)];
}

nlohmann::ordered_json errors_json(const MetricErrors& errors) {
    nlohmann::ordered_json json;
    for (int i = 0; i < metric_count; ++i)
        json[name_of(static_cast<Metric>(i))] = errors[static_cast<std::size_t>(i)];
    return json;
}

// Shapes of all lobes: "f0 0.31 m 0.093 alpha 0.2 | f0 1 m 0.4 alpha 0".
std::string parameters_text(const Material& material) {
    std::string text;
    for (const Lobe& lobe : material.lobes) {
        if (!text.empty())
            text += " |";
        const std::vector<Parameter>& parameters = lobe.model->parameters(lobe.isotropic);
        for (std::size_t i = 0; i < parameters.size(); ++i)
            text += fmt::format("{}{} {:.4g}", text.empty() ? "" : " ", parameters[i].name,
                                lobe.theta[i]);
    }
    return text.empty() ? "-" : text;
}

// A CSV field, quoted where it has to be.
std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos)
        return text;
    std::string quoted = "\"";
    for (const char c : text)
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

// 1234567890 as "1.23 G".
std::string with_prefix(double value) {
    for (const auto& [scale, prefix] : {std::pair{1e9, " G"}, {1e6, " M"}, {1e3, " k"}})
        if (value >= scale)
            return fmt::format("{:.3g}{}", value / scale, prefix);
    return fmt::format("{:.3g}", value);
}

} // namespace

nlohmann::ordered_json fit_record(const FitResult& result, const Samples& samples,
                                  const FitOptions& options, const Device& device) {
    nlohmann::ordered_json record;
    record["source"] = samples.source;
    record["sha256"] = samples.sha256;
    record["metric"] = name_of(options.metric);
    record["error"] = errors_json(result.errors);
    record["samples"] = result.samples;
    record["max_theta"] = options.max_theta;
    record["algorithm"] = options.algorithm;
    record["evaluations"] = result.evaluations;
    record["seconds"] = result.seconds;
    nlohmann::ordered_json errors = nlohmann::ordered_json::object();
    nlohmann::ordered_json at_bound = nlohmann::ordered_json::array();
    for (const FittedParameter& parameter : result.parameters) {
        if (std::isfinite(parameter.standard_error))
            errors[parameter.name] = parameter.standard_error;
        else
            errors[parameter.name] = nullptr;
        if (parameter.at_bound)
            at_bound.push_back(parameter.name);
    }
    record["standard_error"] = std::move(errors);
    record["at_bound"] = std::move(at_bound);
    record["device"] = device.name;
    record["version"] = version;
    return record;
}

std::string fit_table(std::vector<const FitRow*> rows, Metric metric) {
    std::stable_sort(rows.begin(), rows.end(), [&](const FitRow* a, const FitRow* b) {
        return minimised_error(*a, metric) < minimised_error(*b, metric);
    });
    std::vector<std::vector<std::string>> cells{
        {"model", "lobes", fmt::format("{} error", name_of(metric)), "parameters", "evaluations",
         "samples/s", "seconds"}};
    for (const FitRow* row : rows) {
        const FitResult& r = row->result;
        cells.push_back({r.model, fmt::format("{}", r.material.lobes.size()),
                         fmt::format("{:.6g}", minimised_error(*row, metric)),
                         parameters_text(r.material), fmt::format("{}", r.evaluations),
                         with_prefix(r.samples_per_second()), fmt::format("{:.3f}", r.seconds)});
    }
    std::vector<std::size_t> widths(cells.front().size(), 0);
    for (const auto& row : cells)
        for (std::size_t i = 0; i < row.size(); ++i)
            widths[i] = std::max(widths[i], row[i].size());
    std::string text;
    for (const auto& row : cells) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i)
            // Names to the left, numbers to the right.
            line += i == 0 || i == 3 ? fmt::format("{:<{}}  ", row[i], widths[i])
                                     : fmt::format("{:>{}}  ", row[i], widths[i]);
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    return text;
}

nlohmann::ordered_json fit_rows_json(const std::vector<FitRow>& rows, const FitOptions& options) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const FitRow& row : rows) {
        const FitResult& r = row.result;
        nlohmann::ordered_json item;
        item["file"] = row.file;
        item["material_file"] = row.material_file;
        item["model"] = r.model;
        item["lobes"] = r.material.lobes.size();
        item["metric"] = name_of(options.metric);
        item["error"] = errors_json(r.errors);
        nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
        for (const FittedParameter& p : r.parameters) {
            nlohmann::ordered_json entry;
            entry["name"] = p.name;
            entry["value"] = p.value;
            if (std::isfinite(p.standard_error))
                entry["standard_error"] = p.standard_error;
            else
                entry["standard_error"] = nullptr;
            entry["at_bound"] = p.at_bound;
            parameters.push_back(entry);
        }
        item["parameters"] = parameters;
        item["samples"] = r.samples;
        item["evaluations"] = r.evaluations;
        item["thinned_evaluations"] = r.thinned_evaluations;
        if (options.random_starts > 0)
            item["random_starts_better"] = r.random_starts_better;
        item["samples_per_second"] = r.samples_per_second();
        item["build_seconds"] = r.build_seconds;
        item["search_seconds"] = r.search_seconds;
        item["polish_seconds"] = r.polish_seconds;
        item["seconds"] = r.seconds;
        json.push_back(item);
    }
    return json;
}

void write_fit_csv(const std::vector<FitRow>& rows, const FitOptions& options,
                   const std::string& path) {
    OutputFile file(path);
    std::string text = "file,model,lobes,metric";
    for (int i = 0; i < metric_count; ++i)
        text += fmt::format(",error_{}", name_of(static_cast<Metric>(i)));
    text += ",samples,evaluations,seconds,material_file,parameters\n";
    for (const FitRow& row : rows) {
        const FitResult& r = row.result;
        text += fmt::format("{},{},{},{}", csv_field(row.file), r.model, r.material.lobes.size(),
                            name_of(options.metric));
        for (const double error : r.errors)
            text += fmt::format(",{}", error);
        std::string parameters;
        for (const FittedParameter& p : r.parameters)
            parameters += fmt::format("{}{}={}", parameters.empty() ? "" : ";", p.name, p.value);
        text += fmt::format(",{},{},{:.6f},{},{}\n", r.samples, r.evaluations, r.seconds,
                            csv_field(row.material_file), csv_field(parameters));
    }
    file.write(text);
    file.commit();
}

} // namespace brdfit

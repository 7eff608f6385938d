#include "fit/report.hpp"

#include "host/device/kernels.hpp"
#include "host/device/tuning.hpp"
#include "host/evaluate/sample.hpp"
#include "host/files/json.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <unordered_set>

namespace brdfit {

namespace {

double minimised_error(const FitRow& row, Metric metric) {
    return row.result.errors[static_cast<std::size_t>(metric)];
}

void add_albedo(nlohmann::ordered_json& json, const LargestAlbedo& albedo) {
    if (std::isfinite(albedo.value))
        json["largest_albedo"] = {
            {"R", albedo.value}, {"theta", albedo.theta}, {"channel", albedo.channel}};
    else
        json["largest_albedo"] = nullptr;
}

// The errors with as many decimals as give the least four digits, so that the points align.
std::vector<std::string> aligned_errors(const std::vector<const FitRow*>& rows, Metric metric) {
    double least = std::numeric_limits<double>::infinity();
    for (const FitRow* row : rows)
        if (minimised_error(*row, metric) > 0)
            least = std::min(least, minimised_error(*row, metric));
    const int decimals =
        std::isfinite(least)
            ? std::clamp(3 - static_cast<int>(std::floor(std::log10(least))), 2, 12)
            : 6;
    std::vector<std::string> texts;
    for (const FitRow* row : rows)
        texts.push_back(fmt::format("{:.{}f}", minimised_error(*row, metric), decimals));
    return texts;
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
    if (text.find_first_of(",\"\r\n") == std::string::npos)
        return text;
    std::string quoted = "\"";
    for (const char c : text)
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

// 1234567890 as "1.23 G".
std::string with_prefix(double value) {
    if (value == 0)
        return "-"; // not measured
    for (const auto& [scale, prefix] : {std::pair{1e9, " G"}, {1e6, " M"}, {1e3, " k"}})
        if (value >= scale)
            return fmt::format("{:.3g}{}", value / scale, prefix);
    return fmt::format("{:.3g}", value);
}

// The value of a parameter, "lobes[0].m", "kd[R]", in a material file.
double value_of(const std::string& name, const Json& json, const Material& material) {
    std::string rest = name;
    const Json* of = &json.at("diffuse");
    if (rest.rfind("lobes[", 0) == 0) {
        const std::size_t end = rest.find("].");
        of = &json.at("lobes").at(std::stoul(rest.substr(6, end - 6)));
        rest.erase(0, end + 2);
    }
    const std::size_t bracket = rest.find('[');
    if (bracket == std::string::npos)
        return of->at(rest).get<double>();
    const std::string channel = rest.substr(bracket + 1, rest.size() - bracket - 2);
    const auto place = std::find(material.channels.begin(), material.channels.end(), channel);
    return of->at(rest.substr(0, bracket))
        .at(static_cast<std::size_t>(place - material.channels.begin()))
        .get<double>();
}

double number_or_nan(const Json& value) {
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

} // namespace

nlohmann::ordered_json errors_json(const MetricErrors& errors) {
    nlohmann::ordered_json json;
    for (int i = 0; i < metric_count; ++i)
        json[name_of(static_cast<Metric>(i))] = errors[static_cast<std::size_t>(i)];
    return json;
}

std::string column_name(const std::string& parameter) {
    std::string name;
    std::size_t at = 0;
    if (parameter.rfind("lobes[", 0) == 0) {
        at = parameter.find("].");
        name = fmt::format("l{}_", std::stoi(parameter.substr(6)) + 1);
        at += 2;
    }
    const std::string rest = parameter.substr(at);
    const std::size_t bracket = rest.find('[');
    return bracket == std::string::npos ? name + rest
                                        : name + rest.substr(0, bracket) + "_" +
                                              rest.substr(bracket + 1, rest.size() - bracket - 2);
}

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
    record["max_evaluations"] = options.max_evaluations;
    record["starts"] = options.random_starts;
    if (options.random_starts > 0)
        record["random_starts_better"] = result.random_starts_better;
    record["seed"] = options.seed;
    record["ranges"] = nlohmann::ordered_json::array();
    for (const ParameterRange& range : options.ranges)
        record["ranges"].push_back(text_of(range));
    record["conserve"] = options.conserve;
    record["warm_start"] = options.start.has_value();
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
    add_albedo(record, result.largest_albedo);
    record["remarks"] = remarks_on(result);
    record["device"] = device.name;
    record["driver"] = device.driver;
    record["form"] = to_json(device.form);
    record["kernels"] = kernel_hash();
    record["algorithm_version"] = algorithm_version;
    record["version"] = version;
    return record;
}

FitResult recorded_fit(Material material) {
    const Json& fit = material.fit;
    const Json json = to_json(material);
    FitResult r;
    r.model = drawn_structure(material).name();
    for (int i = 0; i < metric_count; ++i)
        r.errors[static_cast<std::size_t>(i)] =
            fit.at("error").at(name_of(static_cast<Metric>(i))).get<double>();
    const auto at_bound = fit.at("at_bound").get<std::vector<std::string>>();
    for (const auto& [name, error] : fit.at("standard_error").items())
        r.parameters.push_back(
            {name, value_of(name, json, material), number_or_nan(error),
             std::find(at_bound.begin(), at_bound.end(), name) != at_bound.end()});
    r.samples = fit.at("samples").get<std::size_t>();
    r.evaluations = fit.at("evaluations").get<std::size_t>();
    r.seconds = fit.at("seconds").get<double>();
    r.random_starts = fit.at("starts").get<int>();
    r.random_starts_better = fit.value("random_starts_better", 0);
    if (const Json& albedo = fit.at("largest_albedo"); !albedo.is_null())
        r.largest_albedo = {albedo.at("R").get<double>(), albedo.at("theta").get<double>(),
                            albedo.at("channel").get<std::string>()};
    r.material = std::move(material);
    return r;
}

std::vector<std::string> remarks_on(const FitResult& result) {
    std::vector<std::string> remarks;
    std::string bound;
    for (const FittedParameter& p : result.parameters)
        if (p.at_bound && p.name.back() != ']') // kd and ks of a channel may well be 0
            bound += (bound.empty() ? "" : ", ") + column_name(p.name);
    if (!bound.empty())
        remarks.push_back("at bound: " + bound);
    const LargestAlbedo& albedo = result.largest_albedo;
    if (albedo.above_1())
        remarks.push_back(fmt::format("R {:.3g} at {:.0f} degrees", albedo.value, albedo.theta));
    if (result.random_starts_better > 0)
        remarks.push_back(fmt::format("{} of {} random starts better", result.random_starts_better,
                                      result.random_starts));
    return remarks;
}

std::string fit_table(std::vector<const FitRow*> rows, Metric metric) {
    std::stable_sort(rows.begin(), rows.end(), [&](const FitRow* a, const FitRow* b) {
        return minimised_error(*a, metric) < minimised_error(*b, metric);
    });
    std::vector<std::vector<std::string>> cells{
        {"model", "lobes", fmt::format("{} error", name_of(metric)), "parameters", "evaluations",
         "samples/s", "seconds", "compiling", "remarks"}};
    const std::vector<std::string> errors = aligned_errors(rows, metric);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const FitResult& r = rows[i]->result;
        cells.push_back({r.model, fmt::format("{}", r.material.lobes.size()), errors[i],
                         parameters_text(r.material), fmt::format("{}", r.evaluations),
                         with_prefix(r.samples_per_second()), fmt::format("{:.3f}", r.seconds),
                         fmt::format("{:.3f}", r.build_seconds),
                         fmt::format("{}", fmt::join(remarks_on(r), "; "))});
    }
    if (std::any_of(rows.begin(), rows.end(), [](auto row) { return row->outside_peak; })) {
        cells[0].push_back(fmt::format("ngan, theta_h > {}", peak_theta));
        for (std::size_t i = 0; i < rows.size(); ++i)
            cells[i + 1].push_back(fmt::format("{:.4g}", rows[i]->outside_peak.value_or(0)));
        for (auto& row : cells) // beside the error
            std::rotate(row.begin() + 3, row.end() - 1, row.end());
    }
    const std::size_t extra = cells[0].size() - 9;
    std::vector<std::size_t> widths(cells.front().size(), 0);
    for (const auto& row : cells)
        for (std::size_t i = 0; i < row.size(); ++i)
            widths[i] = std::max(widths[i], row[i].size());
    std::string text;
    for (const auto& row : cells) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i)
            // Words to the left, numbers to the right.
            line += i == 0 || i == 3 + extra || i == 8 + extra
                        ? fmt::format("{:<{}}  ", row[i], widths[i])
                        : fmt::format("{:>{}}  ", row[i], widths[i]);
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    return text;
}

nlohmann::ordered_json fit_rows_json(const FitRows& rows, const FitOptions& options) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const FitRow& row : rows.done) {
        const FitResult& r = row.result;
        nlohmann::ordered_json item;
        item["file"] = row.file;
        item["material_file"] = row.material_file;
        item["model"] = r.model;
        item["lobes"] = r.material.lobes.size();
        item["metric"] = name_of(options.metric);
        item["error"] = errors_json(r.errors);
        if (row.outside_peak)
            item["error_outside_peak"] = {{"theta_h", peak_theta}, {"ngan", *row.outside_peak}};
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
        add_albedo(item, r.largest_albedo);
        item["remarks"] = remarks_on(r);
        item["samples"] = r.samples;
        item["evaluations"] = r.evaluations;
        item["thinned_evaluations"] = r.thinned_evaluations;
        if (r.random_starts > 0)
            item["random_starts_better"] = r.random_starts_better;
        item["samples_per_second"] = r.samples_per_second();
        item["build_seconds"] = r.build_seconds;
        item["search_seconds"] = r.search_seconds;
        item["polish_seconds"] = r.polish_seconds;
        item["seconds"] = r.seconds;
        json.push_back(item);
    }
    for (const FailedFit& failed : rows.failed) {
        nlohmann::ordered_json item{{"file", failed.file}};
        if (!failed.model.empty()) {
            item["model"] = failed.model;
            item["lobes"] = failed.lobes;
        }
        item["failed"] = failed.reason;
        json.push_back(item);
    }
    return json;
}

FitCsv::FitCsv(const std::string& path, const std::vector<std::string>& parameters)
    : writer_(path) {
    std::string head = "file,model,lobes,metric";
    for (int i = 0; i < metric_count; ++i)
        head += fmt::format(",error_{}", name_of(static_cast<Metric>(i)));
    head += ",samples,evaluations,seconds,build_seconds,random_starts,random_starts_better,"
            "largest_albedo,remarks,failed,material_file";
    for (const std::string& name : parameters) {
        place_.emplace(name, place_.size());
        for (const char* what : {"", "_se", "_at_bound"})
            head += "," + csv_field(column_name(name) + what);
    }
    writer_.bytes(head + '\n');
}

void FitCsv::add(const FitRow& row, Metric metric) {
    const auto number = [](double value) {
        return std::isfinite(value) ? fmt::format("{}", value) : std::string();
    };
    const FitResult& r = row.result;
    std::string text = fmt::format("{},{},{},{}", csv_field(row.file), r.model,
                                   r.material.lobes.size(), name_of(metric));
    for (const double error : r.errors)
        text += fmt::format(",{}", error);
    text += fmt::format(
        ",{},{},{:.6f},{:.6f},{},{},{},{},,{}", r.samples, r.evaluations, r.seconds,
        r.build_seconds, r.random_starts, r.random_starts_better, number(r.largest_albedo.value),
        csv_field(fmt::format("{}", fmt::join(remarks_on(r), "; "))), csv_field(row.material_file));
    std::vector<const FittedParameter*> of_row(place_.size(), nullptr);
    for (const FittedParameter& p : r.parameters)
        of_row[place_.at(p.name)] = &p;
    for (const FittedParameter* p : of_row)
        text += p == nullptr ? ",,,"
                             : fmt::format(",{},{},{}", p->value, number(p->standard_error),
                                           p->at_bound ? 1 : 0);
    writer_.bytes(text + '\n');
    writer_.end_row();
}

void FitCsv::add(const FailedFit& failed, Metric metric) {
    writer_.bytes(
        fmt::format("{},{},{},{},,,,,,,,,,,,,{},{}\n", csv_field(failed.file), failed.model,
                    failed.model.empty() ? "" : fmt::format("{}", failed.lobes), name_of(metric),
                    csv_field(failed.reason), std::string(3 * place_.size(), ',')));
    writer_.end_row();
}

void write_fit_csv(const FitRows& rows, const FitOptions& options, const std::string& path) {
    std::vector<std::string> parameters; // of any row, in the order they first come
    std::unordered_set<std::string> known;
    for (const FitRow& row : rows.done)
        for (const FittedParameter& p : row.result.parameters)
            if (known.insert(p.name).second)
                parameters.push_back(p.name);
    FitCsv csv(path, parameters);
    for (const FitRow& row : rows.done)
        csv.add(row, options.metric);
    for (const FailedFit& failed : rows.failed)
        csv.add(failed, options.metric);
    csv.commit();
}

} // namespace brdfit

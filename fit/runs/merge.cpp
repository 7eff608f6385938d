#include "fit/runs/merge.hpp"

#include "fit/runs/tables.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <memory>
#include <unordered_set>

namespace brdfit {

namespace {

// A task with the row that tells its result.
struct Chosen {
    const Task* task;
    RowPlace row;
    bool done;
    double error = std::numeric_limits<double>::quiet_NaN(); // the one it minimised
};

// By what a row was made: results of two may differ in their last digits.
std::string maker_of(const Json& row) {
    const Json& fit = row.at("material").at("fit");
    std::string form;
    for (const auto& [key, value] : fit.at("form").items())
        form += (form.empty() ? "" : " ") + key + " " + dumped(value);
    return fmt::format("{}, driver {}, form {}, kernels {:.8}, brdfit {}",
                       fit.at("device").get<std::string>(), fit.at("driver").get<std::string>(),
                       form, fit.at("kernels").get<std::string>(),
                       fit.at("version").get<std::string>());
}

// What of a row is the same whenever and wherever it is made.
Json timeless(Json row) {
    for (const char* key : {"finished", "shard", "host", "times"})
        row.erase(key);
    Json& fit = row.at("material").at("fit");
    fit.erase("seconds");
    fit.erase("source"); // copies of a file
    return row;
}

double minimised_error(const Json& row, const Task& task) {
    return row.at("material").at("fit").at("error").at(name_of(task.metric)).get<double>();
}

// Throws InputError where two rows of a task are two results; notes who made the second, and how
// far they differ.
void compare(const Task& task, const RunLogs& logs, const RowPlace& a, const RowPlace& b,
             MergeReport& report) {
    const Json first = logs.read(a), second = logs.read(b);
    ++report.made_by[maker_of(second)]; // that of the first is counted with the chosen
    if (timeless(first) == timeless(second))
        return;
    const double e = minimised_error(first, task), f = minimised_error(second, task);
    const double difference = std::abs(e - f) / std::max(std::abs(e), std::abs(f));
    const bool unlike_devices = maker_of(first) != maker_of(second);
    if (!unlike_devices || !(difference <= same_error))
        throw InputError(fmt::format("{} and {} are of one task and differ, with {} errors of {} "
                                     "and {}; expected one result: "
                                     "remove the wrong line",
                                     logs.name(a), logs.name(b), name_of(task.metric), e, f));
    report.largest_difference = std::max(report.largest_difference, difference);
}

std::vector<Chosen> chosen_rows(const Plan& plan, const RunLogs& logs, MergeReport& report) {
    std::vector<Chosen> chosen;
    std::unordered_set<std::string> compared;
    for (const Task& task : plan.tasks) {
        const auto found = logs.tasks.find(task.id);
        if (found == logs.tasks.end()) {
            ++report.left;
            continue;
        }
        const Finished& rows = found->second;
        if (rows.done.empty()) {
            ++report.failed;
            chosen.push_back({&task, *rows.failed, false});
            continue;
        }
        ++report.done;
        chosen.push_back({&task, rows.done.front(), true});
        if (compared.insert(task.id).second)
            for (std::size_t i = 1; i < rows.done.size(); ++i, ++report.duplicates)
                try {
                    compare(task, logs, rows.done.front(), rows.done[i], report);
                } catch (const Json::exception&) {
                    throw InputError(fmt::format("{} or {}: is not a row of a run",
                                                 logs.name(rows.done.front()),
                                                 logs.name(rows.done[i])));
                }
    }
    return chosen;
}

FitResult result_of(const Json& row, const Task& task, Material material) {
    const Json& times = row.at("times");
    FitResult r = recorded_fit(std::move(material));
    r.model = task.structure.name();
    r.thinned_evaluations = row.at("thinned_evaluations").get<std::size_t>();
    r.build_seconds = times.at("build_seconds").get<double>();
    r.search_seconds = times.at("search_seconds").get<double>();
    r.polish_seconds = times.at("polish_seconds").get<double>();
    return r;
}

FailedFit failed_fit(const Json& row, const Task& task, const PlannedFile& file,
                     const std::string& place) {
    const Json* const reason = optional(row, "reason");
    return {file.path, task.structure.name(), task.structure.lobes.size(),
            parse_text(reason != nullptr ? *reason : Json(), Place{place, "reason"}, "a text")};
}

// Keeps, for each file and metric, the fit of the least error.
std::vector<Chosen> best_of(const std::vector<Chosen>& chosen) {
    std::map<std::pair<std::size_t, Metric>, const Chosen*> best;
    for (const Chosen& fit : chosen) {
        const Chosen*& known = best[{fit.task->file, fit.task->metric}];
        if (known == nullptr || fit.error < known->error)
            known = &fit;
    }
    std::vector<Chosen> kept;
    for (const Chosen& fit : chosen)
        if (best[{fit.task->file, fit.task->metric}] == &fit)
            kept.push_back(fit);
    return kept;
}

class Merger {
  public:
    Merger(const Plan& plan, const RunLogs& logs, const MergeOutputs& outputs)
        : plan_(plan), logs_(logs), outputs_(outputs) {}

    // Reads every row for the database, and learns what the other outputs need to know.
    void read_all(std::vector<Chosen>& chosen, MergeReport& report,
                  const ProgressFunction& progress) {
        std::unique_ptr<RunTables> tables;
        if (!outputs_.database.empty())
            tables = std::make_unique<RunTables>(outputs_.database, plan_);
        std::unordered_set<std::string> known;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            tell(progress, static_cast<double>(i) / static_cast<double>(chosen.size()));
            try {
                read(chosen[i], tables.get(), known, report);
            } catch (const Json::exception& error) {
                throw InputError(fmt::format("{}: is not a row of a run: {}",
                                             logs_.name(chosen[i].row), error.what()));
            }
        }
        if (tables)
            tables->commit(report.done, report.failed, report.left);
    }

    void write_csv(const std::vector<Chosen>& chosen, const ProgressFunction& progress) {
        FitCsv csv(outputs_.csv, parameters_);
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            tell(progress, static_cast<double>(i) / static_cast<double>(chosen.size()));
            const Chosen& fit = chosen[i];
            const Json row = logs_.read(fit.row);
            if (fit.done)
                csv.add(done(fit, row), fit.task->metric);
            else
                csv.add(failed(fit, row), fit.task->metric);
        }
        csv.commit();
    }

    void write_materials(const std::vector<Chosen>& chosen, const ProgressFunction& progress) {
        make_output_folder(outputs_.materials);
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            tell(progress, static_cast<double>(i) / static_cast<double>(chosen.size()));
            const FitRow whole = done(chosen[i], logs_.read(chosen[i].row));
            write_material(
                whole.result.material,
                (std::filesystem::path(outputs_.materials) / whole.material_file).string());
        }
    }

  private:
    void read(Chosen& fit, RunTables* tables, std::unordered_set<std::string>& known,
              MergeReport& report) {
        const Json row = logs_.read(fit.row);
        if (!fit.done) {
            if (tables != nullptr)
                tables->add(failed(fit, row), *fit.task, row);
            return;
        }
        const FitRow whole = done(fit, row);
        fit.error = whole.result.errors[static_cast<std::size_t>(fit.task->metric)];
        ++report.made_by[maker_of(row)];
        for (const FittedParameter& p : whole.result.parameters)
            if (known.insert(p.name).second)
                parameters_.push_back(p.name);
        if (tables != nullptr)
            tables->add(whole, *fit.task, row);
    }
    FitRow done(const Chosen& fit, const Json& row) const {
        return fit_row(row, *fit.task, plan_.files[fit.task->file], logs_.name(fit.row));
    }
    FailedFit failed(const Chosen& fit, const Json& row) const {
        return failed_fit(row, *fit.task, plan_.files[fit.task->file], logs_.name(fit.row));
    }

    const Plan& plan_;
    const RunLogs& logs_;
    const MergeOutputs& outputs_;
    std::vector<std::string> parameters_; // of any row, in the order they first come
};

} // namespace

FitRow fit_row(const Json& row, const Task& task, const PlannedFile& file,
               const std::string& place) {
    try {
        Material material = parse_material(dumped(row.at("material")), place);
        material.fit["source"] = file.path; // it may have been made from a copy
        return {file.path, task.output, result_of(row, task, std::move(material))};
    } catch (const Json::exception& error) {
        throw InputError(fmt::format("{}: is not a row of a run: {}", place, error.what()));
    } catch (const std::logic_error& error) { // stoul
        throw InputError(fmt::format("{}: is not a row of a run: {}", place, error.what()));
    }
}

MergeReport read_rows(const Plan& plan, const std::string& folder, const RowReaders& readers,
                      const ProgressFunction& progress) {
    const RunLogs logs = read_logs(folder);
    MergeReport report;
    report.broken = logs.broken();
    const std::vector<Chosen> chosen = chosen_rows(plan, logs, report);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        tell(progress, static_cast<double>(i) / static_cast<double>(chosen.size()));
        const Chosen& fit = chosen[i];
        const Json row = logs.read(fit.row);
        const PlannedFile& file = plan.files[fit.task->file];
        const std::string place = logs.name(fit.row);
        if (!fit.done) {
            readers.failed(failed_fit(row, *fit.task, file, place), *fit.task);
            continue;
        }
        readers.done(fit_row(row, *fit.task, file, place), *fit.task);
        try {
            ++report.made_by[maker_of(row)];
        } catch (const Json::exception& error) {
            throw InputError(fmt::format("{}: is not a row of a run: {}", place, error.what()));
        }
    }
    return report;
}

MergeReport merge_run(const Plan& plan, const std::string& folder, const MergeOutputs& outputs,
                      const ProgressFunction& progress) {
    const RunLogs logs = read_logs(folder);
    MergeReport report;
    report.broken = logs.broken();
    std::vector<Chosen> chosen = chosen_rows(plan, logs, report);
    Merger merger(plan, logs, outputs);
    merger.read_all(chosen, report, part_of(progress, 0, 0.5));
    if (!outputs.csv.empty())
        merger.write_csv(chosen, part_of(progress, 0.5, 0.75));
    if (!outputs.materials.empty()) {
        chosen.erase(std::remove_if(chosen.begin(), chosen.end(),
                                    [](const Chosen& fit) { return !fit.done; }),
                     chosen.end());
        if (outputs.best)
            chosen = best_of(chosen);
        merger.write_materials(chosen, part_of(progress, 0.75, 1));
        report.materials = chosen.size();
    }
    return report;
}

} // namespace brdfit

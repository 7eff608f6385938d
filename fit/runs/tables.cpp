#include "fit/runs/tables.hpp"

#include "host/version.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>

namespace brdfit {

namespace {

constexpr const char* schema = R"(
BEGIN;
CREATE TABLE settings (key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID;
CREATE TABLE files (file INTEGER PRIMARY KEY, path TEXT, sha256 TEXT, bytes INTEGER);
CREATE TABLE fits (
  fit INTEGER PRIMARY KEY, task TEXT, file INTEGER REFERENCES files, path TEXT,
  model TEXT, lobes INTEGER, diffuse TEXT, metric TEXT, state TEXT, failed TEXT,
  error REAL, error_ngan REAL, error_l2 REAL, error_log REAL, error_cbrt REAL,
  samples INTEGER, evaluations INTEGER, thinned_evaluations INTEGER,
  starts INTEGER, random_starts_better INTEGER,
  largest_albedo REAL, largest_albedo_theta REAL, largest_albedo_channel TEXT, remarks TEXT,
  seconds REAL, build_seconds REAL, search_seconds REAL, polish_seconds REAL,
  finished REAL, shard TEXT, host TEXT,
  device TEXT, driver TEXT, form TEXT, kernels TEXT, version TEXT, algorithm_version INTEGER,
  material_file TEXT, material TEXT);
CREATE TABLE parameters (
  fit INTEGER REFERENCES fits, lobe INTEGER, parameter TEXT, value REAL, standard_error REAL,
  at_bound INTEGER);
)";

std::string question_marks(int count) {
    std::string marks = "?";
    for (int i = 1; i < count; ++i)
        marks += ", ?";
    return marks;
}

} // namespace

RunTables::CreateTables::CreateTables(Database& database) {
    database.run(schema);
}

RunTables::RunTables(const std::string& path, const Plan& plan)
    : file_(path), database_(file_.path_until_commit(), path), created_(database_),
      setting_(database_, "INSERT INTO settings VALUES (?, ?)"),
      file_row_(database_, "INSERT INTO files VALUES (?, ?, ?, ?)"),
      done_(database_, fmt::format("INSERT INTO fits VALUES ({})", question_marks(39))),
      failed_(database_,
              fmt::format("INSERT INTO fits (fit, task, file, path, model, lobes, diffuse, metric, "
                          "state, failed, finished, shard, host, material_file) VALUES ({})",
                          question_marks(14))),
      parameter_(database_, "INSERT INTO parameters VALUES (?, ?, ?, ?, ?, ?)") {
    add_settings(plan);
    for (std::size_t f = 0; f < plan.files.size(); ++f)
        file_row_(f, plan.files[f].path, plan.files[f].sha256,
                  static_cast<std::size_t>(plan.files[f].bytes));
}

void RunTables::add_settings(const Plan& plan) {
    const Json settings = settings_json(plan);
    for (const auto& [key, value] : settings.items())
        setting_(key, value.is_string() ? value.get<std::string>() : dumped(value));
    setting_("folder", plan.folder);
    setting_("version", version);
    setting_("tasks", fmt::format("{}", plan.tasks.size()));
}

void RunTables::add(const FitRow& fit, const Task& task, const Json& row) {
    const FitResult& r = fit.result;
    const Json& record = r.material.fit;
    const auto text = [](const Json& of, const char* key) { return of.at(key).get<std::string>(); };
    ++fits_;
    done_(fits_, task.id, task.file, fit.file, r.model, r.material.lobes.size(),
          diffuse_name_of(*task.structure.diffuse), name_of(task.metric), "done", nullptr,
          r.errors[static_cast<std::size_t>(task.metric)], r.errors[0], r.errors[1], r.errors[2],
          r.errors[3], r.samples, r.evaluations, r.thinned_evaluations, r.random_starts,
          r.random_starts_better, r.largest_albedo.value, r.largest_albedo.theta,
          r.largest_albedo.channel, fmt::format("{}", fmt::join(remarks_on(r), "; ")), r.seconds,
          r.build_seconds, r.search_seconds, r.polish_seconds, row.at("finished").get<double>(),
          text(row, "shard"), text(row, "host"), text(record, "device"), text(record, "driver"),
          dumped(record.at("form")), text(record, "kernels"), text(record, "version"),
          record.at("algorithm_version").get<int>(), fit.material_file,
          dumped(to_json(r.material)));
    for (const FittedParameter& p : r.parameters) {
        // "l1_m" is m of lobe 1, "kd_R" of the diffuse part
        std::string name = column_name(p.name);
        int lobe = 0;
        if (p.name.rfind("lobes[", 0) == 0) {
            lobe = std::stoi(name.substr(1));
            name.erase(0, name.find('_') + 1);
        }
        parameter_(fits_, lobe, name, p.value, p.standard_error, p.at_bound);
    }
}

void RunTables::add(const FailedFit& fit, const Task& task, const Json& row) {
    const auto text = [&](const char* key) { return row.value(key, std::string()); };
    ++fits_;
    failed_(fits_, task.id, task.file, fit.file, fit.model, fit.lobes,
            diffuse_name_of(*task.structure.diffuse), name_of(task.metric), "failed", fit.reason,
            row.at("finished").get<double>(), text("shard"), text("host"), task.output);
}

void RunTables::commit(std::size_t done, std::size_t failed, std::size_t left) {
    setting_("done", fmt::format("{}", done));
    setting_("failed", fmt::format("{}", failed));
    setting_("left", fmt::format("{}", left));
    database_.run("CREATE INDEX parameters_of_fit ON parameters (fit); COMMIT");
    file_.commit(true);
}

} // namespace brdfit

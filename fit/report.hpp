#pragma once

#include "fit/fit.hpp"
#include "host/files/columns.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace brdfit {

/// A fit of one file, with where its material was written.
struct FitRow {
    std::string file;
    std::string material_file;
    FitResult result;
    /// error_outside_peak, where it is asked for: only `generate --from` shows it.
    std::optional<double> outside_peak = {};
};

/// A fit that failed, or where `model` is empty a whole file.
struct FailedFit {
    std::string file, model;
    std::size_t lobes = 0;
    std::string reason;
};

struct FitRows {
    std::vector<FitRow> done;
    std::vector<FailedFit> failed;
};

/// What makes a fit doubtful, for people: a parameter at its bound, R above 1, a random start that
/// was better.
std::vector<std::string> remarks_on(const FitResult& result);

/// The errors by the names of their metrics.
nlohmann::ordered_json errors_json(const MetricErrors& errors);

/// What a material file says of how it was fitted (its key `fit`).
nlohmann::ordered_json fit_record(const FitResult& result, const Samples& samples,
                                  const FitOptions& options, const Device& device);

/// The fit that a material's record tells of, but its times apart and thinned evaluations; `model`
/// is the structure's name. Throws Json::exception or std::logic_error where it has no such record.
FitResult recorded_fit(Material material);

/// The rows of one file as a table, sorted by the error the fits minimised.
std::string fit_table(std::vector<const FitRow*> rows, Metric metric);

/// The rows for programs: file, material_file, model, lobes, errors, parameters, remarks, counts
/// and times; of what failed, file, model, lobes and `failed`, the reason.
nlohmann::ordered_json fit_rows_json(const FitRows& rows, const FitOptions& options);

/// "l1_m" for the parameter "lobes[0].m", "kd_R" for "kd[R]", "l1_ks_R" for "lobes[0].ks[R]".
std::string column_name(const std::string& parameter);

/// A summary as CSV, which appears whole or not at all: a row a fit, one column each for file,
/// model, lobes, metric, the errors, counts, times, remarks and the reason of a failure; then for
/// each parameter its value, standard error (_se) and whether it is at its bound (_at_bound), under
/// its column_name.
class FitCsv {
  public:
    /// `parameters`: those of all rows to come, in the order of their columns.
    FitCsv(const std::string& path, const std::vector<std::string>& parameters);
    void add(const FitRow& row, Metric metric);
    void add(const FailedFit& failed, Metric metric);
    void commit() { writer_.commit(); }

  private:
    RowWriter writer_;
    std::unordered_map<std::string, std::size_t> place_; ///< of a parameter
};

/// Writes the rows so, those that failed at the end.
void write_fit_csv(const FitRows& rows, const FitOptions& options, const std::string& path);

} // namespace brdfit

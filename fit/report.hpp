#pragma once

#include "fit/fit.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
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

/// What a material file says of how it was fitted (its key `fit`).
nlohmann::ordered_json fit_record(const FitResult& result, const Samples& samples,
                                  const FitOptions& options, const Device& device);

/// The rows of one file as a table, sorted by the error the fits minimised.
std::string fit_table(std::vector<const FitRow*> rows, Metric metric);

/// The rows for programs: file, material_file, model, lobes, errors, parameters, remarks, counts
/// and times; of what failed, file, model, lobes and `failed`, the reason.
nlohmann::ordered_json fit_rows_json(const FitRows& rows, const FitOptions& options);

/// Writes the rows as CSV, whole or not at all: one a fit, one column each for file, model, lobes,
/// metric, the errors, counts, times, remarks and the reason of a failure; then for each parameter
/// of any row its value, standard error (_se) and whether it is at its bound (_at_bound): l1_m of
/// the first lobe, kd_R and l1_ks_R of channel R.
void write_fit_csv(const FitRows& rows, const FitOptions& options, const std::string& path);

} // namespace brdfit

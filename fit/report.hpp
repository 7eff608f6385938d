#pragma once

#include "fit/fit.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace brdfit {

/// A fit of one file, with where its material was written.
struct FitRow {
    std::string file;
    std::string material_file;
    FitResult result;
};

/// What a material file says of how it was fitted (its key `fit`).
nlohmann::ordered_json fit_record(const FitResult& result, const Samples& samples,
                                  const FitOptions& options, const Device& device);

/// The rows of one file as a table, sorted by the error the fits minimised.
std::string fit_table(std::vector<const FitRow*> rows, Metric metric);

/// The rows for programs: file, material_file, model, lobes, errors, parameters, counts and times.
nlohmann::ordered_json fit_rows_json(const std::vector<FitRow>& rows, const FitOptions& options);

/// Writes the rows as CSV, whole or not at all: one a fit, one column each for file, model, lobes,
/// metric, the errors, samples, evaluations, seconds, and the parameters as one text.
void write_fit_csv(const std::vector<FitRow>& rows, const FitOptions& options,
                   const std::string& path);

} // namespace brdfit

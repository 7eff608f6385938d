#pragma once

#include "fit/report.hpp"
#include "fit/runs/database.hpp"
#include "fit/runs/plan.hpp"
#include "host/files/file.hpp"

namespace brdfit {

/// The SQLite file of a run that merge_run describes; it appears whole or not at all.
class RunTables {
  public:
    RunTables(const std::string& path, const Plan& plan);

    /// Fits are numbered in the order they come. `row`: as it was logged.
    void add(const FitRow& fit, const Task& task, const Json& row);
    void add(const FailedFit& fit, const Task& task, const Json& row);
    void commit(std::size_t done, std::size_t failed, std::size_t left);

  private:
    void add_settings(const Plan& plan);

    OutputFile file_;
    Database database_;
    struct CreateTables {
        explicit CreateTables(Database& database);
    } created_;
    Statement setting_, file_row_, done_, failed_, parameter_;
    std::size_t fits_ = 0;
};

} // namespace brdfit

#pragma once

#include "fit/jobs.hpp"
#include "host/cli/isotropy.hpp"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace brdfit::cli {

/// The options that say what to fit to which files, and how, which several commands have.
class FitSettings {
  public:
    void add_to(CLI::App& command);
    /// The request they make, without its metric, checked. Throws UsageError and, for the material
    /// of --start, InputError.
    FitRequest request() const;

  private:
    FitRequest request_; // what CLI11 can fill in
    std::string algorithm_ = "slsqp", start_;
    std::vector<std::string> fixes_, bounds_;
    const CLI::Option* seed_ = nullptr;
    Isotropy isotropy_;
};

} // namespace brdfit::cli

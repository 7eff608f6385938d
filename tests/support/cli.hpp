#pragma once

#include "host/model/material.hpp"
#include "tests/support/support.hpp"

#include <csignal>
#include <functional>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// What the tests of the command line share.

namespace brdfit::test {

using Names = std::vector<std::string>;
Names names_in(const std::filesystem::path& folder); ///< sorted; none where there is no folder

/// A folder with paint.json (isotropic kurt), brushed.json (anisotropic ward) and paint.csv, a
/// small noisy measurement of the first.
class Cli : public testing::Test {
  protected:
    Cli();
    void synthesise(const std::string& material, const std::string& file, int count = 600);
    /// Runs `fit` on the measurement, to the folder out, whose files it may replace.
    Outcome fit(const std::vector<std::string>& options) const;
    nlohmann::json fit_json(std::vector<std::string> options) const;
    Material written(const std::string& name) const;
    Names out_names() const;

    TemporaryFolder folder;
};

/// Runs the program and sends it a signal as soon as a file stands in the folder for whose name
/// `seen` holds.
Outcome interrupted(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::function<bool(const std::string& name)>& seen, int signal = SIGINT);

void expect_usage_error(const Outcome& outcome, const std::string& says);
void expect_input_error(const Outcome& outcome, const std::string& says);

} // namespace brdfit::test

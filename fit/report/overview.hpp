#pragma once

#include "fit/report/results.hpp"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace brdfit {

/// A model with so many lobes; what has none (lambert) counts as of one.
struct Column {
    std::string model;
    std::size_t lobes;
};

/// The fits of results by material, model and lobes. The results must outlive it.
class Overview {
  public:
    explicit Overview(const Results& results);

    const Results& results() const { return *results_; }
    /// In the order of their mean errors with the fewest lobes.
    const std::vector<std::string>& models() const { return models_; }
    const std::vector<std::size_t>& lobes() const { return lobes_; } ///< ascending
    bool has(const Column& column) const;
    /// The fit, or nullptr.
    const ReportedFit* fit(std::size_t material, const Column& column) const;
    /// Why it failed, as an index of Results::failures.
    std::optional<std::size_t> failure(std::size_t material, const Column& column) const;
    /// The fit of the least error: of all, or of those with so many lobes.
    const ReportedFit* best(std::size_t material, std::size_t lobes = 0) const;
    /// Mean error over the materials that have the fit; NaN where none has.
    double mean(const Column& column) const;
    /// In how many materials it is the best of those with its lobes.
    std::size_t wins(const Column& column) const;
    /// By how much the column's error is below that with one lobe less, relative, in the mean over
    /// the materials that have both; NaN where none has.
    double gain(const Column& column) const;

  private:
    using Key = std::tuple<std::size_t, std::string, std::size_t>;

    const Results* results_;
    std::vector<std::string> models_;
    std::vector<std::size_t> lobes_;
    std::map<Key, const ReportedFit*> fits_;
    std::map<Key, std::size_t> failures_;
};

} // namespace brdfit

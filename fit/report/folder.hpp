#pragma once

#include "fit/report/results.hpp"

#include <string>

namespace brdfit {

/// The results in a folder that `fit` wrote, see read_results; `metric` as in Selection.
Results results_of_fits(const std::string& folder, const std::string& metric,
                        const ProgressFunction& progress);

} // namespace brdfit

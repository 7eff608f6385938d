#pragma once

#include "fit/report/overview.hpp"

#include <string>

namespace brdfit {

/// Errors of every model over the materials, a plot for each number of lobes (Fig. 6 and 8 of Kurt
/// et al. 2010), and mean errors against mean times; empty with fewer than two materials.
std::string figures_html(const Overview& overview);

} // namespace brdfit

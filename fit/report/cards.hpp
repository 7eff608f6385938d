#pragma once

#include "fit/report/overview.hpp"
#include "fit/report/page.hpp"

namespace brdfit {

/// A card a material: spheres of the data, of the best fit and of the chosen one, plots and
/// parameters. Throws like report_page.
std::string cards_html(const Overview& overview, const ReportOptions& options,
                       const std::function<Device()>& device);

} // namespace brdfit

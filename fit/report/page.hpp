#pragma once

#include "fit/report/results.hpp"
#include "host/device/device.hpp"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace brdfit {

/// How a report is drawn.
struct ReportOptions {
    std::size_t size = 192;   ///< of pictures, pixels; 0: none, and no plots
    std::size_t samples = 32; ///< a pixel
    /// The fit that each material's best is set beside: a model, or MODEL:LOBES; empty: the model
    /// of one lobe whose mean error is the least.
    std::string model;
    /// A material's card begins; `done` of all are finished. Never called by two threads at once.
    std::function<void(const std::string& material, std::size_t done)> next;
};
inline constexpr std::size_t most_report_size = 1024;

/// A page of HTML that tells of results and needs no other file. `device` is not opened where
/// there are no pictures. Throws UsageError for a model that no fit has.
std::string report_page(const Results& results, const ReportOptions& options,
                        const std::function<Device()>& device);

} // namespace brdfit

#pragma once

#include "fit/report/page.hpp"
#include "host/device/device.hpp"
#include "host/evaluate/measured.hpp"
#include "host/render/scene.hpp"

#include <memory>
#include <mutex>
#include <string>

namespace brdfit {

/// Of cards made at once: held while kernels run whose runs differ in size
/// (SharedProgram::running).
struct DeviceTurns {
    std::mutex of_data, of_material, of_albedo;
};

/// Draws what a card shows, as HTML.
class CardPictures {
  public:
    CardPictures(const Device& device, const ReportOptions& options, DeviceTurns& turns);

    /// A material's data (nullptr: missing), best and chosen fit (nullptr: none, or the same).
    std::string html_of(const std::string& name, const std::shared_ptr<const MeasuredBrdf>& data,
                        const ReportedFit* best, const ReportedFit* chosen) const;

  private:
    Device device_;
    ReportOptions options_;
    DeviceTurns& turns_;
    Scene scene_;
};

} // namespace brdfit

#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/evaluate/measured.hpp"
#include "host/model/material.hpp"
#include "host/progress.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A material or a measured file, as a function of directions.
class Brdf {
  public:
    explicit Brdf(Material material) : material_(std::move(material)) {}
    explicit Brdf(std::shared_ptr<const MeasuredBrdf> measured) : measured_(std::move(measured)) {}

    /// The measured file, or nullptr: a material.
    const MeasuredBrdf* measured() const { return measured_.get(); }
    const std::vector<std::string>& channels() const;
    bool isotropic() const;
    /// 1/sr, [channel][pair]; 0 below the horizon.
    std::vector<float> evaluate(const Device& device, const Directions& directions,
                                const ProgressFunction& progress = {}) const;

  private:
    std::optional<Material> material_;
    std::shared_ptr<const MeasuredBrdf> measured_;
};

} // namespace brdfit

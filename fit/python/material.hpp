#pragma once

#include "fit/python/call.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/sample.hpp"
#include "host/model/material.hpp"

#include <map>
#include <memory>
#include <mutex>

namespace brdfit::python {

/// A material as Python has it, never changed, with what was made for it on devices.
class SharedMaterial {
  public:
    explicit SharedMaterial(Material material) : material_(std::move(material)) {}

    const Material& material() const { return material_; }
    /// That of a device.
    std::shared_ptr<const Evaluator> evaluator(const Device& device) const {
        const std::lock_guard<std::mutex> lock(mutex_);
        std::shared_ptr<const Evaluator>& evaluator = evaluators_[&device];
        if (!evaluator)
            evaluator = std::make_shared<const Evaluator>(device, material_);
        return evaluator;
    }
    /// Calls use(sampler) with that of a device, one call at a time.
    template <typename Use>
    auto with_sampler(const Device& device, Use use) const {
        const std::lock_guard<std::mutex> lock(sampling_);
        std::unique_ptr<Sampler>& sampler = samplers_[&device];
        if (!sampler)
            sampler = std::make_unique<Sampler>(device, material_);
        return use(*sampler);
    }

  private:
    const Material material_;
    mutable std::mutex mutex_; // of the evaluators
    mutable std::map<const Device*, std::shared_ptr<const Evaluator>> evaluators_;
    mutable std::mutex sampling_; // of the samplers
    mutable std::map<const Device*, std::unique_ptr<Sampler>> samplers_;
};

} // namespace brdfit::python

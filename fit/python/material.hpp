#pragma once

#include "fit/python/call.hpp"
#include "host/evaluate/sample.hpp"
#include "host/model/material.hpp"

#include <map>
#include <memory>
#include <mutex>

namespace brdfit::python {

/// A material as Python has it, never changed, with the samplers made for it.
class SharedMaterial {
  public:
    explicit SharedMaterial(Material material) : material_(std::move(material)) {}

    const Material& material() const { return material_; }
    /// Calls use(sampler) with that of a device, one call at a time.
    template <typename Use>
    auto with_sampler(const Device& device, Use use) const {
        const std::lock_guard<std::mutex> lock(mutex_);
        std::unique_ptr<Sampler>& sampler = samplers_[&device];
        if (!sampler)
            sampler = std::make_unique<Sampler>(device, material_);
        return use(*sampler);
    }

  private:
    const Material material_;
    mutable std::mutex mutex_; // of the samplers
    mutable std::map<const Device*, std::unique_ptr<Sampler>> samplers_;
};

} // namespace brdfit::python

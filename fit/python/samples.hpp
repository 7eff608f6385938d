#pragma once

#include "host/device/device.hpp"
#include "host/evaluate/measured.hpp"
#include "host/measured/samples.hpp"

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace brdfit::python {

/// Samples as Python has them: from a file or from arrays, never changed.
class SampleSet {
  public:
    /// Read from a file; see read_samples.
    SampleSet(const std::string& path, std::optional<bool> isotropic);
    explicit SampleSet(Samples samples);

    const Samples& samples() const { return *samples_; }
    const std::shared_ptr<const Samples>& shared() const { return samples_; }
    /// As a function of directions, made where it is asked for first. Throws InputError where a
    /// file has changed since it was read.
    std::shared_ptr<const MeasuredBrdf> brdf();

  private:
    std::shared_ptr<const Samples> samples_;
    std::optional<bool> isotropic_; // what it was read with
    std::mutex mutex_;              // of what is below
    std::shared_ptr<const MeasuredBrdf> brdf_;
};

} // namespace brdfit::python

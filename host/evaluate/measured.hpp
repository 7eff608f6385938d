#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/evaluate/scattered.hpp"
#include "host/measured/rgl.hpp"
#include "host/measured/samples.hpp"
#include "host/progress.hpp"

#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A measured file as a function of directions: RGL files by their warp, on the device; MERL and
/// UTIA files linearly on their grids; scattered samples by Shepard's method (see ScatteredBrdf).
class MeasuredBrdf {
  public:
    /// Throws InputError for a file that cannot be read or has no valid sample. `isotropic` as
    /// read_samples takes it.
    explicit MeasuredBrdf(const std::string& path, std::optional<bool> isotropic = std::nullopt);
    /// Of scattered samples, of no file. Throws InputError, naming their source, where none is
    /// valid.
    explicit MeasuredBrdf(Samples samples);

    const Samples& samples() const { return samples_; }
    const std::vector<std::string>& channels() const { return samples_.channels; }
    bool isotropic() const { return samples_.isotropic; }
    /// How it is evaluated, for people.
    const char* method() const;
    /// Where values between the samples are those of scattered ones, otherwise nullptr.
    const ScatteredBrdf* scattered() const { return scattered_ ? &*scattered_ : nullptr; }
    /// Of an RGL file, otherwise nullptr.
    const RglTables* tables() const { return tables_ ? &*tables_ : nullptr; }

    /// 1/sr, [channel][pair]; 0 below the horizon.
    std::vector<float> evaluate(const Device& device, const Directions& directions,
                                const ProgressFunction& progress = {}) const;

  private:
    enum class Method { Warp, Merl, Utia, Scattered };

    Samples samples_;
    Method method_ = Method::Scattered;
    std::optional<RglTables> tables_;
    std::optional<ScatteredBrdf> scattered_;
};

} // namespace brdfit

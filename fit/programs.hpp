#pragma once

#include "host/albedo/integrator.hpp"
#include "host/device/device.hpp"
#include "host/model/structure.hpp"

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace brdfit {

/// A program for fitting one structure to files of some number of channels.
struct FitProgram {
    Structure structure;
    StructureLayout layout;
    cl::Program program;
    /// Nanoseconds that first runs of its kernels took: many drivers compile only then.
    mutable std::atomic<std::int64_t> first_runs{0};
};

/// Builds each program once for a device. Safe to call from several threads.
class ProgramCache {
  public:
    explicit ProgramCache(const Device& device) : device_(device) {}
    std::shared_ptr<const FitProgram> get(const Structure& structure, int channels, int chunk);
    /// Products of rows, for the global search.
    const cl::Program& gram();
    /// Albedos of a component: of the lobe, or of the diffuse shape where one is given, which may
    /// go with the lobe. See AlbedoIntegrator; not for models that need a table.
    std::vector<AlbedoValue> albedos(const Model* diffuse, const Model* lobe,
                                     const std::vector<AlbedoTask>& tasks);
    /// Seconds spent on programs so far, first runs of kernels included.
    double build_seconds();

  private:
    struct Entry {
        std::string key;
        std::shared_ptr<const FitProgram> program;
    };
    const Device& device_;
    std::mutex mutex_;
    std::vector<Entry> entries_;
    std::optional<cl::Program> gram_;
    std::mutex albedo_mutex_;
    std::map<std::pair<const Model*, const Model*>, AlbedoIntegrator> integrators_;
    double seconds_ = 0; // of builds
};

} // namespace brdfit

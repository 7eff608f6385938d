#pragma once

#include "host/albedo/integrator.hpp"
#include "host/device/device.hpp"
#include "host/made_once.hpp"
#include "host/model/structure.hpp"

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace brdfit {

/// Seconds that each thread spends on programs, first runs of kernels included: many drivers
/// compile only then.
class BuildSeconds {
  public:
    void add(double seconds);
    double of_this_thread();

  private:
    std::mutex mutex_;
    std::map<std::thread::id, double> seconds_;
};

/// A program that several queues of a device run.
struct SharedProgram {
    cl::Program program;
    /// Held while one of its kernels runs: PoCL 3.1 aborts (pocl_release_dlhandle_cache) where
    /// three runs of one kernel overlap, the last of them the largest so far.
    mutable std::mutex running;
};

/// A program for fitting one structure to files of some number of channels.
struct FitProgram : SharedProgram {
    Structure structure;
    StructureLayout layout;
    std::shared_ptr<BuildSeconds> build_seconds; ///< for first runs of its kernels
};

/// Builds each program once for a device. Safe to call from several threads.
class ProgramCache {
  public:
    explicit ProgramCache(const Device& device) : device_(device) {}
    std::shared_ptr<const FitProgram> get(const Structure& structure, int channels, int chunk);
    /// Builds what a fit of a structure needs, so that it is there when the fit begins. Never
    /// throws: what cannot be built fails there.
    void build_ahead(const Structure& structure, int channels, int chunk) noexcept;
    /// Products of rows, for the global search.
    const SharedProgram& gram();
    /// Albedos of a component: of the lobe, or of the diffuse shape where one is given, which may
    /// go with the lobe. See AlbedoIntegrator; not for models that need a table.
    std::vector<AlbedoValue> albedos(const Model* diffuse, const Model* lobe,
                                     const std::vector<AlbedoTask>& tasks);
    /// Seconds that this thread has spent on programs so far, first runs of kernels included.
    double build_seconds() { return seconds_->of_this_thread(); }

  private:
    // The one of a component, built and run once with a task like those it will be given.
    AlbedoIntegrator& integrator(const Model* diffuse, const Model* lobe, AlbedoTask like);

    const Device& device_;
    MadeOnce<std::shared_ptr<const FitProgram>> programs_;
    MadeOnce<std::shared_ptr<const SharedProgram>> gram_;
    std::mutex albedo_mutex_;
    std::map<std::pair<const Model*, const Model*>, AlbedoIntegrator> integrators_;
    std::shared_ptr<BuildSeconds> seconds_ = std::make_shared<BuildSeconds>();
};

} // namespace brdfit

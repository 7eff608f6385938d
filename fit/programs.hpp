#pragma once

#include "host/device/device.hpp"
#include "host/model/structure.hpp"

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A program for fitting one structure to files of some number of channels.
struct FitProgram {
    Structure structure;
    StructureLayout layout;
    cl::Program program;
};

/// Builds each program once for a device. Safe to call from several threads.
class ProgramCache {
  public:
    explicit ProgramCache(const Device& device) : device_(device) {}
    std::shared_ptr<const FitProgram> get(const Structure& structure, int channels, int chunk);
    /// Products of rows, for the global search.
    const cl::Program& gram();

  private:
    struct Entry {
        std::string key;
        std::shared_ptr<const FitProgram> program;
    };
    const Device& device_;
    std::mutex mutex_;
    std::vector<Entry> entries_;
    std::optional<cl::Program> gram_;
};

} // namespace brdfit

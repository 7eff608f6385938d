#pragma once

#include "host/device/device.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace brdfit::test {

/// A new empty folder that goes with the object.
class TemporaryFolder {
  public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    /// Path of a file in it.
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

void write_file(const std::string& path, const std::string& bytes);
std::string read_file(const std::string& path);

/// What a run of the program left.
struct Outcome {
    int status; ///< exit status; 128 + signal when it was killed
    std::string out, err;
};

/// Runs brdfit with these arguments and waits for it. `environment`: variables as NAME=VALUE, added
/// to this process's. `meanwhile` is called while it runs.
Outcome run_program(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {},
                    const std::function<void(pid_t)>& meanwhile = {});

/// The default device, opened once.
const Device& device();

/// A folder of measured data given by the environment variable BRDFIT_DATA; empty when unset.
std::filesystem::path data_folder();

} // namespace brdfit::test

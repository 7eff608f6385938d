#pragma once

#include "host/device/device.hpp"
#include "host/error.hpp"
#include "host/progress.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace brdfit {
class Generator;
}

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

/// What a run of a program left.
struct Outcome {
    int status; ///< exit status; 128 + signal when it was killed
    std::string out, err;
};

/// Runs a program, by its path or its name, and waits for it. `environment`: variables as
/// NAME=VALUE, added to this process's. `meanwhile` is called while it runs.
Outcome run_command(const std::vector<std::string>& command,
                    const std::vector<std::string>& environment = {},
                    const std::function<void(pid_t)>& meanwhile = {});
/// Runs brdfit with these arguments.
Outcome run_program(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {},
                    const std::function<void(pid_t)>& meanwhile = {});

/// Lets this process take at most so many bytes of addresses more than it has: for a child that is
/// about to end. Not with AddressSanitizer, which needs them all.
void limit_memory(std::size_t more);

/// An environment variable of this process that has another value as long as the object lives;
/// nullptr: none.
class Variable {
  public:
    Variable(const std::string& name, const char* value);
    ~Variable();
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

  private:
    std::string name_;
    std::optional<std::string> before_;
};

/// The message of the Error that an action throws; empty where it throws none. Any other exception
/// passes.
template <typename Error = InputError, typename Action>
std::string complaint(const Action& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

/// Runs an action with a progress and returns the shares that it told. Expects them to grow within
/// [0, 1], and more than two of them.
std::vector<double> told_shares(const std::function<void(const ProgressFunction&)>& action);

/// The default device, opened once.
const Device& device();
/// A generator of microfacet tables on it.
const Generator& generator();

/// A copy of the built-in kernels in a folder, with `to` in place of `from` in one file where that
/// is given. Throws where the file has no `from`.
class KernelFolder {
  public:
    explicit KernelFolder(const std::string& file = "", const std::string& from = "",
                          const std::string& to = "");
    std::string operator/(const std::string& name) const { return folder_ / name; }
    const std::filesystem::path& path() const { return folder_.path(); }

  private:
    TemporaryFolder folder_;
};
/// The text of a built-in kernel file.
std::string kernel_text(const std::string& file);

/// A folder of measured data given by the environment variable BRDFIT_DATA; empty when unset.
std::filesystem::path data_folder();

} // namespace brdfit::test

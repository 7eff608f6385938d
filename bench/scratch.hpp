#pragma once

#include "host/error.hpp"

#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <string>

namespace brdfit::bench {

/// A new temporary folder that goes with the object.
class Scratch {
  public:
    Scratch() {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "brdfit-bench-XXXXXX").string();
        if (mkdtemp(pattern.data()) == nullptr)
            throw InputError(fmt::format("{}: cannot make a temporary folder", pattern));
        path_ = pattern;
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

} // namespace brdfit::bench

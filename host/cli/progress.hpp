#pragma once

#include <cstddef>
#include <string>

namespace brdfit::cli {

/// Progress of a job over a second on stderr: a bar on a terminal, a line now and then elsewhere,
/// nothing with --quiet.
class Progress {
  public:
    Progress(std::size_t total, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Says that `what` comes next, after `done` of the total.
    void show(std::size_t done, const std::string& what);
    /// Removes the bar, so that other text can be printed.
    void clear();

  private:
    std::size_t total_;
    bool bar_, lines_;
    bool shown_ = false;
    double started_, last_line_;
};

} // namespace brdfit::cli

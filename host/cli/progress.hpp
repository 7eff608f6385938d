#pragma once

#include "host/progress.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>

namespace brdfit::cli {

/// Progress of a job over a second on stderr, with the time left by the share done: a bar on a
/// terminal, a line every ten seconds elsewhere, nothing with --quiet.
class Progress {
  public:
    /// A job of `total` steps; one step is shown by its share.
    Progress(std::size_t total, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Says that `what` comes next, after `done` of the total.
    void show(std::size_t done, const std::string& what);
    /// The same, for a step that tells the share of it that is done. Lives no longer than this.
    ProgressFunction step(std::size_t done, const std::string& what);
    /// Removes the bar until the next step, so that other text can be printed.
    void clear();

  private:
    using Clock = std::chrono::steady_clock;

    void wait(); ///< draws, from time to time
    void draw(Clock::time_point now);
    void erase();
    std::string text(Clock::time_point now) const;

    const std::size_t total_;
    const bool bar_;
    std::mutex mutex_; ///< of all below
    std::condition_variable ended_;
    bool end_ = false, hidden_ = true, shown_ = false;
    std::size_t done_ = 0;
    double step_ = 0; ///< share of the step that is done
    std::string what_;
    const Clock::time_point started_;
    Clock::time_point told_;
    std::thread thread_; ///< a step may take long and tell nothing
};

} // namespace brdfit::cli

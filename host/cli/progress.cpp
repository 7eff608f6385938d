#include "host/cli/progress.hpp"

#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace brdfit::cli {

namespace {

constexpr double quiet_seconds = 1; // a job this short shows nothing
constexpr double line_seconds = 10; // between lines where there is no terminal

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace

Progress::Progress(std::size_t total, bool quiet)
    : total_(total), bar_(!quiet && isatty(STDERR_FILENO) == 1), lines_(!quiet && !bar_),
      started_(now()), last_line_(started_) {}

Progress::~Progress() {
    clear();
}

void Progress::show(std::size_t done, const std::string& what) {
    const double time = now();
    if (time - started_ < quiet_seconds)
        return;
    if (bar_) {
        constexpr std::size_t width = 30;
        const std::size_t filled = total_ == 0 ? width : done * width / total_;
        fmt::print(stderr, "\r\033[K[{:#<{}}{:.<{}}] {}/{} {}", "", filled, "", width - filled,
                   done, total_, what.substr(0, 40));
        std::fflush(stderr);
        shown_ = true;
    } else if (lines_ && time - last_line_ >= line_seconds) {
        fmt::print(stderr, "{}/{} {}\n", done, total_, what);
        last_line_ = time;
    }
}

void Progress::clear() {
    if (shown_) {
        fmt::print(stderr, "\r\033[K");
        std::fflush(stderr);
        shown_ = false;
    }
}

} // namespace brdfit::cli

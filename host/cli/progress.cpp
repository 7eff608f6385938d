#include "host/cli/progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace brdfit::cli {

namespace {

using namespace std::chrono_literals;

constexpr auto quiet_time = 1s; // a job this short shows nothing
constexpr auto line_time = 10s; // between lines where there is no terminal
constexpr auto bar_time = 250ms;

double seconds(std::chrono::steady_clock::duration time) {
    return std::chrono::duration<double>(time).count();
}

std::string clock_text(double seconds) {
    const auto whole = static_cast<long>(std::ceil(seconds));
    return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                        : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

/// Columns of the terminal, 80 where it does not say.
std::size_t terminal_width() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// `text` of at most `length` bytes, never cut within a UTF-8 character.
std::string shortened(std::string text, std::size_t length) {
    while (length > 0 && length < text.size() &&
           (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80)
        --length;
    text.resize(std::min(length, text.size()));
    return text;
}

} // namespace

Progress::Progress(std::size_t total, bool quiet)
    : total_(std::max<std::size_t>(total, 1)), bar_(isatty(STDERR_FILENO) == 1),
      started_(Clock::now()), told_(started_) {
    if (!quiet)
        thread_ = std::thread([this] { wait(); });
}

Progress::~Progress() {
    clear();
    if (!thread_.joinable())
        return;
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        end_ = true;
    }
    ended_.notify_one();
    thread_.join();
}

void Progress::show(std::size_t done, const std::string& what) {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = done;
    step_ = 0;
    what_ = what;
    told_ = Clock::now();
    hidden_ = false;
}

ProgressFunction Progress::step(std::size_t done, const std::string& what) {
    show(done, what);
    return [this](double share) {
        const std::lock_guard<std::mutex> lock(mutex_);
        step_ = std::clamp(share, step_, 1.0);
        told_ = Clock::now();
    };
}

void Progress::clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    hidden_ = true;
    erase();
}

void Progress::wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    const Clock::duration between = bar_ ? Clock::duration(bar_time) : line_time;
    for (Clock::time_point next = started_ + std::max<Clock::duration>(quiet_time, between);
         !ended_.wait_until(lock, next, [this] { return end_; }); next += between)
        if (!hidden_)
            draw(Clock::now());
}

std::string Progress::text(Clock::time_point now) const {
    const double share =
        std::min(1.0, (static_cast<double>(done_) + step_) / static_cast<double>(total_));
    // By the time the share done took; where nothing is told for that long, nobody knows.
    const double left =
        share > 0 ? seconds(told_ - started_) * (1 - share) / share - seconds(now - told_) : 0;
    const std::string done =
        total_ == 1 ? fmt::format("{:.0f}%", 100 * share) : fmt::format("{}/{}", done_, total_);
    const std::string time =
        left > 0 ? clock_text(left) + " left" : clock_text(seconds(now - started_)) + " so far";
    if (!bar_)
        return fmt::format("{} {}, {}", done, what_, time);
    constexpr std::size_t width = 30;
    const auto filled = static_cast<std::size_t>(share * width);
    const std::string bar =
        fmt::format("[{:#<{}}{:.<{}}] {} ", "", filled, "", width - filled, done);
    const std::size_t most = terminal_width() - 1, taken = bar.size() + 2 + time.size();
    return shortened(bar + shortened(what_, most > taken ? most - taken : 0) + ", " + time, most);
}

void Progress::draw(Clock::time_point now) {
    if (bar_)
        fmt::print(stderr, "\r\033[K{}", text(now));
    else
        fmt::print(stderr, "{}\n", text(now));
    std::fflush(stderr);
    shown_ = bar_;
}

void Progress::erase() {
    if (!shown_)
        return;
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
    shown_ = false;
}

} // namespace brdfit::cli

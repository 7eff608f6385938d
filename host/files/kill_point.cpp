#include "host/files/kill_point.hpp"

#include <atomic>
#include <csignal>
#include <cstdlib>

namespace brdfit {

bool at_kill_point() {
    static const char* const wished = std::getenv("BRDFIT_KILL_AT");
    static const long number = wished != nullptr ? std::strtol(wished, nullptr, 10) : 0;
    static std::atomic<long> calls{0};
    return number > 0 && ++calls == number;
}

void kill_here() {
    for (;;)
        std::raise(SIGKILL);
}

} // namespace brdfit

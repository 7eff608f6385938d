#pragma once

// A hook for tests of what a killed program leaves behind.

namespace brdfit {

/// Called before each write, sync, cut and rename of files. Where the environment variable
/// BRDFIT_KILL_AT has a number, the call of that number, from 1, returns true: the caller then does
/// half of it, if it has halves, and calls kill_here().
bool at_kill_point();

/// Ends the process as kill -9 does.
[[noreturn]] void kill_here();

/// Both, for what has no halves.
inline void kill_point() {
    if (at_kill_point())
        kill_here();
}

} // namespace brdfit

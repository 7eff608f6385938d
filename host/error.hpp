#pragma once

#include <stdexcept>
#include <string>

namespace brdfit {

/// Bad input (missing, unreadable or broken file, broken material) or a failed job: exit status 1.
/// The message names the file, the place in it and what was expected.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Wrong usage (unknown model, algorithm, metric or parameter, contradictory bounds): exit
/// status 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace brdfit

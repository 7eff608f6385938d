#pragma once

#include <functional>

namespace brdfit {

/// Told the share of a job that is done, in [0, 1], which only grows; never by two threads at once.
/// May be empty.
using ProgressFunction = std::function<void(double share)>;

inline void tell(const ProgressFunction& progress, double share) {
    if (progress)
        progress(share);
}

/// For the part of a job from one share to another.
inline ProgressFunction part_of(const ProgressFunction& progress, double begin, double end) {
    if (!progress)
        return {};
    return [progress, begin, end](double share) { progress(begin + (end - begin) * share); };
}

} // namespace brdfit

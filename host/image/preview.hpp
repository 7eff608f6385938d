#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace brdfit {

/// Values to look at; row 0 is the top one.
struct PreviewPanel {
    std::string name;
    std::size_t width = 0, height = 0;
    std::vector<float> values; ///< [y * width + x]
};

/// Writes panels from left to right as a grey PNG, whole or not at all: small ones enlarged,
/// large ones thinned out, 0 and less black, the largest finite value of each white. Returns what
/// is seen, for people. Throws like require_preview_ending, and InputError where the file cannot be
/// written.
std::string write_preview(const std::vector<PreviewPanel>& panels, const std::string& path);
/// Throws UsageError unless the ending is .png.
void require_preview_ending(const std::string& path);

} // namespace brdfit

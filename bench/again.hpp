#pragma once

#include <string>
#include <utility>
#include <vector>

namespace brdfit::bench {

/// Runs this program again with these arguments, and these environment variables set for what reads
/// them only when it starts; returns what it wrote to standard output. Throws InputError where it
/// failed.
std::string run_again(const std::vector<std::string>& arguments,
                      const std::vector<std::pair<std::string, std::string>>& variables);

} // namespace brdfit::bench

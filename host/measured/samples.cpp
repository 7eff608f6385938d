#include "host/measured/samples.hpp"

#include <algorithm>

namespace brdfit {

std::size_t Samples::valid_count() const {
    return count() -
           static_cast<std::size_t>(std::count(valid.begin(), valid.end(), std::uint8_t{0}));
}

} // namespace brdfit

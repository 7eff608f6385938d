#pragma once

#include "host/image/image.hpp"
#include "host/microfacet/table.hpp"

#include <memory>
#include <string>
#include <vector>

namespace brdfit {

/// What read_table makes of a file's parts, as read_exr_parts returns them.
std::shared_ptr<const MicrofacetTable> table_of(std::vector<Image> parts, const std::string& path);

} // namespace brdfit

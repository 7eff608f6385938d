#pragma once

namespace brdfit {

inline constexpr const char* version = "0.1.0";

} // namespace brdfit

#pragma once

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <string>

namespace brdfit::cli {

/// Checks that an option is a number from `low` to `high`. CLI::Range lets NaN through.
inline CLI::Validator within(double low, double high) {
    return CLI::Validator(
        [low, high](std::string& text) {
            double value = 0;
            const bool number = CLI::detail::lexical_cast(text, value);
            return number && value >= low && value <= high
                       ? std::string()
                       : fmt::format("'{}': expected a number from {} to {}", text, low, high);
        },
        fmt::format("FLOAT in [{} - {}]", low, high));
}

} // namespace brdfit::cli

#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// Reading JSON strictly: every error names the file, the path of keys and what was expected there.

namespace brdfit {

using Json = nlohmann::ordered_json;

/// Where in which file: the source's name and the path of keys.
struct Place {
    const std::string& source;
    std::string path;

    Place member(const std::string& key) const;
    Place element(std::size_t i) const;

    /// Throw InputError naming the place.
    [[noreturn]] void fail(const std::string& problem) const;
    [[noreturn]] void fail(const Json& value, const std::string& expected) const;
};

/// Parses a text. Throws InputError for what is no JSON, for a key given twice and for nesting
/// deeper than 32 levels; `expected` says what the file should be.
Json parse_json(const std::string& text, const std::string& source, const std::string& expected);

/// These throw InputError naming the place.
void check_object(const Json& value, const Place& at, const std::string& expected);
/// Where a key is not among the allowed ones.
void check_keys(const Json& object, const Place& at, const std::vector<std::string>& allowed);
/// The member `key`; where it is missing: an error.
const Json& required(const Json& object, const Place& at, const std::string& key,
                     const std::string& expected);
/// A number in [lower, upper].
double parse_number(const Json& value, const Place& at, double lower, double upper);

/// JSON for people: what fits is on one line, and so is every array of plain values.
std::string pretty(const Json& value, std::size_t indent = 0);

} // namespace brdfit

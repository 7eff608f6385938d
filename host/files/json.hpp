#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
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

/// What any JSON may be at most, whoever wrote it: copying recurses, and objects find keys one by
/// one. A fit's record has a key for each strength of its diffuse part and lobes in each channel.
inline constexpr std::size_t max_json_depth = 32, max_json_keys = 24576;

/// Parses a text. Throws InputError for what is no JSON, for a key given twice, for nesting deeper
/// than max_json_depth and objects of more than max_json_keys; `expected` says what the file should
/// be.
Json parse_json(std::string_view text, const std::string& source, const std::string& expected);
/// Parses a file of at most `most_bytes`. Throws InputError like parse_json and MappedFile.
Json read_json(const std::string& path, const std::string& expected, std::size_t most_bytes);

/// These throw InputError naming the place.
void check_object(const Json& value, const Place& at, const std::string& expected);
/// Where a key is not among the allowed ones.
void check_keys(const Json& object, const Place& at, const std::vector<std::string>& allowed);
/// The member `key`; where it is missing: an error.
const Json& required(const Json& object, const Place& at, const std::string& key,
                     const std::string& expected);
/// A number in [lower, upper].
double parse_number(const Json& value, const Place& at, double lower, double upper);
std::string parse_text(const Json& value, const Place& at, const std::string& expected);
bool parse_bool(const Json& value, const Place& at);
/// The value that a text stands for among the known ones.
template <typename Value>
Value parse_choice(const Json& value, const Place& at,
                   const std::vector<std::pair<const char*, Value>>& known) {
    std::string names;
    for (const auto& [name, meaning] : known) {
        if (value == name)
            return meaning;
        names += (names.empty() ? "" : ", ") + std::string(name);
    }
    at.fail(value, "one of " + names);
}
/// The member `key`, or nullptr.
const Json* optional(const Json& object, const std::string& key);

/// Whether a text is UTF-8, as texts of JSON are.
bool is_utf8(std::string_view text);
/// Json::dump where texts need not be UTF-8 (names of files): bytes that are not become U+FFFD.
std::string dumped(const Json& value, int indent = -1);
/// JSON for people: what fits is on one line, and so is every array of plain values.
std::string pretty(const Json& value, std::size_t indent = 0);

} // namespace brdfit

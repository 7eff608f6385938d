#include "host/files/json.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <set>

namespace brdfit {

namespace {

constexpr std::size_t line_width = 100;

/// `text` shortened to what a message can hold, never within a UTF-8 character.
std::string shortened(std::string text, std::size_t length = 60) {
    if (text.size() <= length)
        return text;
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80)
        --length;
    text.resize(length);
    return text + "...";
}

/// A key as it stands in a path: as it is when it is a plain word, otherwise quoted.
std::string shown_key(const std::string& key) {
    const bool plain = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '_' || c == '-';
    });
    return shortened(plain ? key : dumped(Json(key)));
}

/// A value as a message shows it.
std::string shown(const Json& value) {
    if (value.is_object())
        return "an object";
    return value.is_array() ? "an array" : shortened(dumped(value));
}

/// Refuses what the parser accepts silently: a key given twice, nesting too deep for the recursions
/// of whoever copies or prints the result, and more keys than objects find quickly.
class Guard {
  public:
    explicit Guard(const std::string& source) : source_(source) {}

    bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
        using Event = Json::parse_event_t;
        switch (event) {
        case Event::key:
            open_.back().key = parsed.get<std::string>();
            if (!open_.back().keys.insert(open_.back().key).second)
                place().fail("is given twice; expected once");
            if (open_.back().keys.size() > max_json_keys)
                place().fail(fmt::format("stands in an object of more than {} keys; expected fewer",
                                         max_json_keys));
            break;
        case Event::object_start:
        case Event::array_start:
            count_element();
            if (depth >= static_cast<int>(max_json_depth))
                Place{source_, ""}.fail(fmt::format(
                    "is nested too deeply; expected at most {} levels", max_json_depth));
            open_.push_back({event == Event::array_start, {}, {}, 0});
            break;
        case Event::value:
            count_element();
            break;
        case Event::object_end:
        case Event::array_end:
            open_.pop_back();
            break;
        }
        return true;
    }

  private:
    struct Container {
        bool array;
        std::string key;
        std::set<std::string> keys;
        std::size_t elements;
    };

    void count_element() {
        if (!open_.empty())
            ++open_.back().elements;
    }
    Place place() const {
        Place at{source_, ""};
        for (const Container& container : open_)
            at.path = container.array ? at.element(container.elements - 1).path
                                      : at.member(container.key).path;
        return at;
    }

    const std::string& source_;
    std::vector<Container> open_;
};

std::string one_line(const Json& value) {
    if (!value.is_structured())
        return dumped(value);
    std::string text;
    for (const auto& [key, element] : value.items())
        text += (text.empty() ? "" : ", ") +
                (value.is_object() ? dumped(Json(key)) + ": " : std::string()) + one_line(element);
    return value.is_object() ? "{" + text + "}" : "[" + text + "]";
}

} // namespace

Place Place::member(const std::string& key) const {
    return {source, path + (path.empty() ? "" : ".") + shown_key(key)};
}

Place Place::element(std::size_t i) const {
    return {source, fmt::format("{}[{}]", path, i)};
}

void Place::fail(const std::string& problem) const {
    throw InputError(path.empty() ? fmt::format("{}: {}", source, problem)
                                  : fmt::format("{}: {}: {}", source, path, problem));
}

void Place::fail(const Json& value, const std::string& expected) const {
    fail(fmt::format("is {}; expected {}", shown(value), expected));
}

Json parse_json(std::string_view text, const std::string& source, const std::string& expected) {
    try {
        return Json::parse(text, Guard(source));
    } catch (const Json::exception& error) {
        std::string what = error.what(); // "[json.exception.NAME.ID] message"
        const auto end = what.find("] ");
        if (end != std::string::npos)
            what.erase(0, end + 2);
        throw InputError(
            fmt::format("{}: is no JSON: {}; expected {}", source, shortened(what, 200), expected));
    }
}

Json read_json(const std::string& path, const std::string& expected, std::size_t most_bytes) {
    const MappedFile file(path);
    if (file.bytes().size() > most_bytes && file.bytes().front() != '{')
        throw InputError(fmt::format("{}: is no JSON; expected {}", path, expected));
    if (file.bytes().size() > most_bytes)
        throw InputError(fmt::format("{}: has {} bytes; expected {} of at most {}", path,
                                     file.bytes().size(), expected, most_bytes));
    return parse_json(file.bytes(), path, expected);
}

void check_object(const Json& value, const Place& at, const std::string& expected) {
    if (!value.is_object())
        at.fail(value, expected);
}

void check_keys(const Json& object, const Place& at, const std::vector<std::string>& allowed) {
    for (const auto& [key, value] : object.items())
        if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
            at.member(key).fail(
                fmt::format("is an unknown key; expected one of {}", fmt::join(allowed, ", ")));
}

const Json& required(const Json& object, const Place& at, const std::string& key,
                     const std::string& expected) {
    const auto found = object.find(key);
    if (found == object.end())
        at.member(key).fail("is missing; expected " + expected);
    return *found;
}

double parse_number(const Json& value, const Place& at, double lower, double upper) {
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!(number >= lower && number <= upper))
        at.fail(value, fmt::format("a number in [{:.6g}, {:.6g}]", lower, upper));
    return number;
}

std::string parse_text(const Json& value, const Place& at, const std::string& expected) {
    if (!value.is_string())
        at.fail(value, expected);
    return value.get<std::string>();
}

bool parse_bool(const Json& value, const Place& at) {
    if (!value.is_boolean())
        at.fail(value, "true or false");
    return value.get<bool>();
}

const Json* optional(const Json& object, const std::string& key) {
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
}

bool is_utf8(std::string_view text) {
    try {
        Json(std::string(text)).dump();
        return true;
    } catch (const Json::exception&) {
        return false;
    }
}

std::string dumped(const Json& value, int indent) {
    return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string pretty(const Json& value, std::size_t indent) {
    std::string line = one_line(value);
    const bool flat = value.is_array() && std::none_of(value.begin(), value.end(),
                                                       [](auto& e) { return e.is_structured(); });
    if (flat || !value.is_structured() || (indent > 0 && indent + line.size() <= line_width))
        return line;
    const std::string margin(indent + 2, ' ');
    std::string text;
    for (const auto& [key, element] : value.items())
        text += (text.empty() ? "\n" : ",\n") + margin +
                (value.is_object() ? dumped(Json(key)) + ": " : std::string()) +
                pretty(element, indent + 2);
    text += "\n" + std::string(indent, ' ');
    return value.is_object() ? "{" + text + "}" : "[" + text + "]";
}

} // namespace brdfit

#pragma once

#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

// What this project needs of SQLite: writing one file, in one go.

namespace brdfit {

/// A database file that is being made. Throws InputError naming it where SQLite cannot.
class Database {
  public:
    /// `path` is an empty file; `name` is what messages call it.
    Database(const std::string& path, std::string name);
    ~Database();
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    void run(const std::string& sql);
    [[noreturn]] void fail() const;
    sqlite3* handle() const { return database_; }

  private:
    std::string name_;
    sqlite3* database_ = nullptr;
};

/// A statement that is run again and again, each time with values for all its question marks.
class Statement {
  public:
    Statement(Database& database, const std::string& sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    /// Binds the values in order and runs it. Numbers that are not finite, nullopt and nullptr are
    /// NULL.
    template <typename... Values>
    void operator()(const Values&... values) {
        int at = 0;
        (bind(++at, values), ...);
        step();
    }

  private:
    void bind(int at, std::string_view text);
    void bind(int at, const std::string& text) { bind(at, std::string_view(text)); }
    void bind(int at, const char* text) { bind(at, std::string_view(text)); }
    void bind(int at, std::nullptr_t);
    void bind(int at, double value);
    void bind(int at, long long value);
    void bind(int at, int value) { bind(at, static_cast<long long>(value)); }
    void bind(int at, bool value) { bind(at, static_cast<long long>(value)); }
    void bind(int at, std::size_t value) { bind(at, static_cast<long long>(value)); }
    void bind(int at, const std::optional<double>& value) {
        value ? bind(at, *value) : bind(at, nullptr);
    }
    void step();

    Database& database_;
    sqlite3_stmt* statement_ = nullptr;
};

} // namespace brdfit

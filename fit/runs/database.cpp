#include "fit/runs/database.hpp"

#include "host/error.hpp"

#include <cmath>
#include <fmt/format.h>
#include <sqlite3.h>
#include <utility>

namespace brdfit {

Database::Database(const std::string& path, std::string name) : name_(std::move(name)) {
    if (sqlite3_open_v2(path.c_str(), &database_, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK) {
        const std::string why = database_ != nullptr ? sqlite3_errmsg(database_) : "out of memory";
        sqlite3_close(database_);
        throw InputError(fmt::format("{}: cannot write: {}", name_, why));
    }
    // Nobody sees the file before it is whole.
    run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");
}

Database::~Database() {
    sqlite3_close(database_);
}

void Database::run(const std::string& sql) {
    if (sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
        fail();
}

void Database::fail() const {
    throw InputError(fmt::format("{}: cannot write: {}", name_, sqlite3_errmsg(database_)));
}

Statement::Statement(Database& database, const std::string& sql) : database_(database) {
    if (sqlite3_prepare_v2(database.handle(), sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK)
        database.fail();
}

Statement::~Statement() {
    sqlite3_finalize(statement_);
}

void Statement::bind(int at, std::string_view text) {
    if (sqlite3_bind_text64(statement_, at, text.data(), text.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8) != SQLITE_OK)
        database_.fail();
}

void Statement::bind(int at, std::nullptr_t) {
    if (sqlite3_bind_null(statement_, at) != SQLITE_OK)
        database_.fail();
}

void Statement::bind(int at, double value) {
    if (!std::isfinite(value))
        bind(at, nullptr);
    else if (sqlite3_bind_double(statement_, at, value) != SQLITE_OK)
        database_.fail();
}

void Statement::bind(int at, long long value) {
    if (sqlite3_bind_int64(statement_, at, value) != SQLITE_OK)
        database_.fail();
}

void Statement::step() {
    if (sqlite3_step(statement_) != SQLITE_DONE || sqlite3_reset(statement_) != SQLITE_OK)
        database_.fail();
}

} // namespace brdfit

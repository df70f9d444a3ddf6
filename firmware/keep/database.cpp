#include "firmware/keep/database.hpp"

#include <sqlite3.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>

namespace spindle_twin::firmware {
namespace {

constexpr int busy_timeout_ms = 2000;  ///< for another program that writes
/// [bytes] of all databases together, each of which keeps 2 MiB of pages: a damaged file claims records of any length,
/// and memory that is locked is taken at once.
constexpr sqlite3_int64 most_memory = 60 << 20;

/// A file that cannot be written beside is read as it stands: SQLite would want to make its index of the WAL there.
std::string uri_of(const std::string& path, Database::Mode mode) {
  std::string uri = "file:";
  for (const char each : path) {
    if (each == '%' || each == '?' || each == '#') {
      constexpr const char* digits = "0123456789ABCDEF";
      const auto code = static_cast<unsigned char>(each);
      uri.append(1, '%').append(1, digits[code >> 4U]).append(1, digits[code & 15U]);
    } else {
      uri += each;
    }
  }
  if (mode == Database::Mode::write) return uri + "?mode=rwc";
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const bool is_writable = access(folder.empty() ? "." : folder.c_str(), W_OK) == 0;
  return uri + (is_writable ? "?mode=ro" : "?mode=ro&immutable=1");
}

}  // namespace

std::string quoted_name(const std::string& name) {
  std::string out = "\"";
  for (const char each : name) {
    out += each;
    if (each == '"') out += each;
  }
  return out + "\"";
}

bool DatabaseError::is_damage() const { return code_ == SQLITE_CORRUPT || code_ == SQLITE_NOTADB; }

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement::Statement(sqlite3* database, const std::string& sql) : database_(database) {
  sqlite3_stmt* made = nullptr;
  const int code = sqlite3_prepare_v2(database, sql.c_str(), -1, &made, nullptr);
  statement_.reset(made);
  check(code);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) throw DatabaseError(code, sqlite3_errmsg(database_));
}

void Statement::bind(int place, double value) {
  check(std::isfinite(value) ? sqlite3_bind_double(statement_.get(), place + 1, value)
                             : sqlite3_bind_null(statement_.get(), place + 1));
}

void Statement::bind(int place, std::int64_t value) { check(sqlite3_bind_int64(statement_.get(), place + 1, value)); }

void Statement::bind(int place, const std::string& value) {
  check(sqlite3_bind_text(statement_.get(), place + 1, value.c_str(), -1, SQLITE_TRANSIENT));
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) throw DatabaseError(code, sqlite3_errmsg(database_));
  return false;
}

void Statement::run() {
  step();
  check(sqlite3_reset(statement_.get()));
}

int Statement::columns() const { return sqlite3_column_count(statement_.get()); }

std::string Statement::column_name(int column) const { return sqlite3_column_name(statement_.get(), column); }

double Statement::number(int column) const {
  if (sqlite3_column_type(statement_.get(), column) == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(statement_.get(), column);
}

std::int64_t Statement::whole(int column) const { return sqlite3_column_int64(statement_.get(), column); }

std::string Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  return text == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(text));
}

void Database::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Database::Database(const std::string& path, Mode mode) {
  sqlite3_hard_heap_limit64(most_memory);
  sqlite3* opened = nullptr;
  const int flags = SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX |
                    (mode == Mode::write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY);
  const int code = sqlite3_open_v2(uri_of(path, mode).c_str(), &opened, flags, nullptr);
  database_.reset(opened);
  if (code != SQLITE_OK) throw DatabaseError(code, opened != nullptr ? sqlite3_errmsg(opened) : "no memory");
  sqlite3_busy_timeout(opened, busy_timeout_ms);
}

void Database::run(const std::string& sql) {
  const int code = sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) throw DatabaseError(code, sqlite3_errmsg(database_.get()));
}

std::int64_t Database::whole(const std::string& sql) {
  Statement statement = prepare(sql);
  return statement.step() ? statement.whole(0) : 0;
}

}  // namespace spindle_twin::firmware

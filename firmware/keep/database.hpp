#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace spindle_twin::firmware {

/// What SQLite says, and its code.
class DatabaseError : public std::runtime_error {
 public:
  DatabaseError(int code, const std::string& text) : std::runtime_error(text), code_(code) {}
  /// The file is no database, or a damaged one.
  bool is_damage() const;

 private:
  int code_;
};

/// A prepared statement. Places and columns count from 0. Every function throws DatabaseError.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& sql);
  void bind(int place, double value);  ///< not finite: NULL
  void bind(int place, std::int64_t value);
  void bind(int place, const std::string& value);
  /// Whether there is a row.
  bool step();
  /// Runs a statement that gives no rows, and makes it ready for the next time.
  void run();
  int columns() const;
  std::string column_name(int column) const;
  double number(int column) const;  ///< NaN: NULL
  std::int64_t whole(int column) const;
  std::string text(int column) const;

 private:
  void check(int code) const;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// The name of a table or column as SQL takes it, whatever stands in it.
std::string quoted_name(const std::string& name);

/// An open SQLite file, for one thread. Closing it ends an open transaction without a trace.
class Database {
 public:
  enum class Mode { write, read };
  /// Writing creates the file. Reading leaves no file behind where the folder cannot be written. Throws DatabaseError.
  Database(const std::string& path, Mode mode);

  void run(const std::string& sql);
  Statement prepare(const std::string& sql) { return {database_.get(), sql}; }
  /// The first number of the first row; 0 where it is NULL.
  std::int64_t whole(const std::string& sql);

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace spindle_twin::firmware

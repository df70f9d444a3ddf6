#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rom/range.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {

/// One table of a TOML document, read strictly: every getter checks type and range, remembers the key as allowed, and
/// throws InputError with file, line, the key's full name and what is allowed. Getters without a default throw when the
/// key is missing. A copy is a handle on the same table. Not for the cycle.
class TomlTable {
 public:
  /// The document's root table. A syntax error or an unreadable file is an InputError.
  static TomlTable read(const std::string& path);
  static TomlTable parse(const std::string& text, const std::string& file);

  bool has(const std::string& key) const;
  bool is_table(const std::string& key) const;

  double number(const std::string& key, Range range = any_number) const;
  double number_or(const std::string& key, double otherwise, Range range = any_number) const;
  std::optional<double> optional_number(const std::string& key, Range range = any_number) const;

  std::int64_t integer(const std::string& key, std::int64_t min, std::int64_t max) const;
  std::int64_t integer_or(const std::string& key, std::int64_t otherwise, std::int64_t min, std::int64_t max) const;

  bool boolean(const std::string& key) const;
  bool boolean_or(const std::string& key, bool otherwise) const;

  std::string string(const std::string& key) const;
  std::string string_or(const std::string& key, const std::string& otherwise) const;
  std::optional<std::string> optional_string(const std::string& key) const;
  /// One of the listed words.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed) const;
  std::string choice_or(const std::string& key, const std::string& otherwise,
                        const std::vector<std::string>& allowed) const;
  /// A name of letters, digits and underscores that starts with a letter.
  std::string name(const std::string& key = "name") const;

  /// Array of numbers; `count` 0 takes any length.
  std::vector<double> numbers(const std::string& key, std::size_t count = 0, Range range = any_number) const;
  /// Array of arrays of `columns` numbers each; empty if the key is missing.
  std::vector<std::vector<double>> rows_or_empty(const std::string& key, std::size_t columns,
                                                 Range range = any_number) const;
  std::vector<std::string> strings(const std::string& key) const;
  std::vector<std::string> strings_or_empty(const std::string& key) const;

  TomlTable table(const std::string& key) const;
  std::optional<TomlTable> optional_table(const std::string& key) const;
  /// Array of tables; empty if the key is missing.
  std::vector<TomlTable> tables_or_empty(const std::string& key) const;
  /// Array of tables with at least one entry.
  std::vector<TomlTable> tables(const std::string& key) const;
  /// All keys present, in the order of the file, each marked as allowed: for tables whose keys are free names.
  std::vector<std::string> free_keys() const;

  SourceLine where() const;
  /// Line of the key, or of the table if the key is missing.
  SourceLine where(const std::string& key) const;
  /// The key's full name, such as "part.shaft.material".
  std::string path(const std::string& key) const;
  /// Shows an entry of an array of tables by name instead of by number in the errors that follow.
  void show_as(const std::string& name) const;
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

  /// Throws InputError for the first key (by line) that nothing asked for, in this table or in any table taken from it.
  void finish() const;

 private:
  struct State;
  explicit TomlTable(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

}  // namespace spindle_twin::rom

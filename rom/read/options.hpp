#pragma once

#include <map>
#include <string>
#include <utility>

#include "rom/option.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::rom {

/// Reads what stands in a table for each option; what does not keeps its value. Throws InputError with file, line, key
/// and what is allowed.
class ReadOptions {
 public:
  explicit ReadOptions(const TomlTable& table) : table_(table) {}

  /// A range that depends on other keys, in place of the option's own.
  ReadOptions& narrow(const std::string& key, Range range) {
    narrowed_[key] = range;
    return *this;
  }

  void operator()(const Option& option, double& value) const;
  void operator()(const Option& option, int& value) const;
  void operator()(const Option& option, bool& value) const;

 private:
  Range range_of(const Option& option) const;

  TomlTable table_;
  std::map<std::string, Range> narrowed_;
};

template <class Options>
void read_options(const TomlTable& table, Options& options) {
  Options::each(options, ReadOptions(table));
}

/// Throws InputError for an option out of its range, named by `prefix` and its key.
class CheckOptions {
 public:
  explicit CheckOptions(std::string prefix = {}) : prefix_(std::move(prefix)) {}

  void operator()(const Option& option, double value) const;
  void operator()(const Option& option, int value) const { (*this)(option, static_cast<double>(value)); }
  void operator()(const Option&, bool) const {}

 private:
  std::string prefix_;
};

}  // namespace spindle_twin::rom

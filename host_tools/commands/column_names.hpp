#pragma once

#include <map>
#include <string>

namespace spindle_twin::host_tools {

/// The head of a CSV of results, built name by name: "time_s,nose_um,...". A name with a comma or a quote is quoted.
class ColumnNames {
 public:
  /// `file`: the network or description that the names come from, for the error.
  explicit ColumnNames(std::string file) : file_(std::move(file)) {}
  /// A column `name` + `suffix`; `of` says of what, "key point". Throws rom::InputError where another thing has a
  /// column of that name already (the key point "shaft_max" and the maximum of the part "shaft").
  void add(const std::string& name, const std::string& suffix, const std::string& of);
  const std::string& text() const { return text_; }

 private:
  std::string file_;
  std::string text_ = "time_s";
  std::map<std::string, std::string> taken_;  ///< whose each column is
};

}  // namespace spindle_twin::host_tools

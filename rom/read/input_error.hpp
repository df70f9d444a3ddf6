#pragma once

#include <stdexcept>
#include <string>

namespace spindle_twin::rom {

/// Where a value was written: file and 1-based line; line 0 when the file has no lines (binary, missing).
struct SourceLine {
  std::string file;
  int line = 0;
};

/// The one error that any bad input ends in: a description, network file, log, schedule or config.
/// what() reads "file:line: field: message"; the message says what is allowed.
class InputError : public std::runtime_error {
 public:
  InputError(const SourceLine& where, const std::string& field, const std::string& message)
      : std::runtime_error(format(where, field, message)) {}

 private:
  static std::string format(const SourceLine& where, const std::string& field, const std::string& message) {
    std::string text = where.file;
    if (where.line > 0) text.append(":").append(std::to_string(where.line));
    if (!text.empty()) text += ": ";
    if (!field.empty()) text += field + ": ";
    return text + message;
  }
};

}  // namespace spindle_twin::rom

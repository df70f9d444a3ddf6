#include "host_tools/commands/column_names.hpp"

#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {

void ColumnNames::add(const std::string& name, const std::string& suffix, const std::string& of) {
  const auto [other, is_new] = taken_.emplace(name + suffix, of + " " + name);
  if (!is_new) {
    throw rom::InputError({file_, 0}, of + " " + name,
                          "its column " + name + suffix + " would be that of " + other->second +
                              " as well; one of the two needs another name");
  }
  const bool quoted = name.find_first_of(",\"") != std::string::npos;
  text_ += quoted ? ",\"" : ",";
  for (const char letter : name) text_ += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  text_ += suffix;
  if (quoted) text_ += '"';
}

}  // namespace spindle_twin::host_tools

#pragma once

#include <map>
#include <regex>
#include <string>
#include <vector>

/// Faults of a person who writes a file: each value of a TOML text removed or made another one, one at a time.
namespace spindle_twin::tests {

struct TextFault {
  std::string what;  ///< "capacity_J_per_K = -1.0"
  std::string text;  ///< the whole file with it
};

/// What a value may be mistaken for; empty: the key is missing.
inline std::vector<std::string> mistaken_for(const std::string& value) {
  if (value.front() == '"') return {"", "\"\"", "\"unknown\"", "7"};
  if (value.front() == '[') return {"", "[]", "[-1.0, 2.0, 3.0, 4.0, 5.0]", "\"text\""};
  if (value == "true" || value == "false") return {"", value == "true" ? "false" : "true", "7"};
  return {"", "-1.0", "0.0", "0.37", "3", "1e30", "nan", "\"text\"", "true"};
}

/// Faults of the first `of_each` values of each key, in the order of the text. Lists are those of one line.
inline std::vector<TextFault> text_faults(const std::string& text, int of_each) {
  static const std::regex entry(R"re(([A-Za-z_][\w.]*) = ("[^"\n]*"|\[[^\]\n]*\]|[-+.\w]+)(, )?)re");
  std::vector<TextFault> faults;
  std::map<std::string, int> seen;
  for (std::sregex_iterator at(text.begin(), text.end(), entry), end; at != end; ++at) {
    const std::smatch& match = *at;
    const auto from = static_cast<std::size_t>(match.position());
    const std::string key = match[1], value = match[2], comma = match[3];
    const std::size_t line = text.rfind('\n', from) + 1;
    if (text.substr(line, from - line).find('#') != std::string::npos || seen[key]++ >= of_each) continue;
    const auto replaced = [&](const std::string& instead) {
      return text.substr(0, from) + instead + text.substr(from + static_cast<std::size_t>(match.length()));
    };
    for (const std::string& other : mistaken_for(value)) {
      const std::string written = other.empty() ? std::string() : key + " = " + other + comma;
      faults.push_back({other.empty() ? "no " + key : key + " = " + other, replaced(written)});
    }
    faults.push_back({key + "_x", replaced(key + "_x = " + value + comma)});
  }
  return faults;
}

}  // namespace spindle_twin::tests

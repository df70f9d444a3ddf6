#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

/// What the program said when its tests were recorded. Such a test states no law: it notices that anything changed at
/// all. Whoever changes it on purpose records anew and reads the difference that git shows (tests/recorded/README.md).
namespace spindle_twin::tests {

/// Words of a line; numbers are compared as numbers.
inline std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// How far a number may be from what it was: by this share of itself, or by this much.
struct Tolerance {
  double relative = 0.0;
  double absolute = 0.0;
};

inline bool is_same_word(const std::string& now, const std::string& then, const Tolerance& tolerance) {
  if (now == then) return true;
  char *end_now = nullptr, *end_then = nullptr;
  const double a = std::strtod(now.c_str(), &end_now), b = std::strtod(then.c_str(), &end_then);
  if (end_now == now.c_str() || *end_now != '\0' || end_then == then.c_str() || *end_then != '\0') return false;
  return std::abs(a - b) <= std::max(tolerance.absolute, tolerance.relative * std::max(std::abs(a), std::abs(b)));
}

/// Every line of `now` is that of tests/recorded/NAME; numbers within `tolerance`, all else to the
/// letter. With SPINDLE_TWIN_RECORD=1 in the environment the file is written in place of that.
inline void expect_as_recorded(const std::string& name, const std::string& now, const Tolerance& tolerance) {
  const std::string path = SPINDLE_TWIN_SOURCE_DIR "/tests/recorded/" + name;
  if (const char* record = std::getenv("SPINDLE_TWIN_RECORD"); record != nullptr && std::string(record) == "1") {
    std::ofstream(path) << now;
    return;
  }
  std::ifstream file(path);
  ASSERT_TRUE(file) << path << " is missing; SPINDLE_TWIN_RECORD=1 makes it";
  std::istringstream lines(now);
  std::string line_now, line_then;
  int number = 0, different = 0;
  while (std::getline(file, line_then)) {
    ++number;
    if (!std::getline(lines, line_now)) line_now = "(nothing)";
    const std::vector<std::string> a = words_of(line_now), b = words_of(line_then);
    const bool same = std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const auto& left, const auto& right) {
      return is_same_word(left, right, tolerance);
    });
    if (!same && ++different <= 10) {
      ADD_FAILURE() << path << ":" << number << "\n  was  " << line_then << "\n  now  " << line_now;
    }
  }
  EXPECT_FALSE(std::getline(lines, line_now))
      << path << " ends before: " << line_now << "; how to record anew: tests/recorded/README.md";
  EXPECT_EQ(different, 0) << "lines that changed, of " << number << "; how to record anew: tests/recorded/README.md";
  EXPECT_GT(number, 0) << path << " is empty";
}

}  // namespace spindle_twin::tests

#pragma once

#include <cstdio>
#include <string>

namespace spindle_twin::correction {

/// As std::printf, up to 240 characters.
template <class... Values>
std::string in_words(const char* format, Values... values) {
  char text[240];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace spindle_twin::correction

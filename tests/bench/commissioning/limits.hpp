#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <vector>

namespace spindle_twin::bench {

inline double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

inline double worst_of(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

inline double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Prints a limit with what was reached; 1 where it is missed.
inline int limit(const char* what, double reached, double limit_at, bool at_least = false) {
  const bool kept = at_least ? reached >= limit_at : reached <= limit_at;
  std::printf("  %-62s %8.2f  %s %5.2f  %s\n", what, reached, at_least ? "at least" : "at most ", limit_at,
              kept ? "kept" : "MISSED");
  return kept ? 0 : 1;
}

}  // namespace spindle_twin::bench

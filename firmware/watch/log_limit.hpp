#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace spindle_twin::firmware {

/// Lets so many lines of one cause pass in each interval, so that neither a broken device nor a stranger on the network
/// can fill a disk. For one thread.
class LogLimit {
 public:
  explicit LogLimit(int lines = 3, double interval_s = 60.0)
      : lines_(lines), interval_ns_(static_cast<std::int64_t>(1e9 * interval_s)) {}

  /// Whether the line is to be written: then how many before it were not; else it is counted. now_ns: monotonic.
  std::optional<std::uint64_t> pass(std::int64_t now_ns) {
    if (passed_ == 0 || now_ns - began_ns_ >= interval_ns_) {
      began_ns_ = now_ns;
      passed_ = 0;
    }
    if (passed_ == lines_) {
      ++held_back_;
      return std::nullopt;
    }
    ++passed_;
    const std::uint64_t before = held_back_;
    held_back_ = 0;
    return before;
  }

  /// For the end of a line.
  static std::string also(std::uint64_t held_back) {
    return held_back == 0 ? std::string() : " (and " + std::to_string(held_back) + " times that were not logged)";
  }

 private:
  int lines_;
  std::int64_t interval_ns_;
  std::int64_t began_ns_ = 0;
  int passed_ = 0;
  std::uint64_t held_back_ = 0;
};

}  // namespace spindle_twin::firmware

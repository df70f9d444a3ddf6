#pragma once

#include <cstdint>
#include <string>

namespace spindle_twin::firmware {

inline constexpr std::int64_t ns_per_s = 1'000'000'000;

/// Seconds since 1970 by the clock on the wall, which may be set; for labels and for the age of files.
double unix_now_s();

/// A time that nobody can set: seconds since a boot, sleeps of the computer included.
struct BootTime {
  std::string boot;  ///< the system's name for the boot; empty: not known
  double s = 0.0;
};
BootTime boot_now();

/// The seam through which the daemon sees time; tests replace it. Never steps back.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t now_ns() const = 0;
  /// Returns at the absolute time, at once if it has passed.
  virtual void sleep_until_ns(std::int64_t time_ns) = 0;
};

/// CLOCK_MONOTONIC and clock_nanosleep with absolute times: sleeping does not add up its own lateness.
class MonotonicClock final : public Clock {
 public:
  std::int64_t now_ns() const override;
  void sleep_until_ns(std::int64_t time_ns) override;
};

}  // namespace spindle_twin::firmware

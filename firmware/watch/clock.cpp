#include "firmware/watch/clock.hpp"

#include <cerrno>
#include <ctime>
#include <fstream>

namespace spindle_twin::firmware {

double unix_now_s() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

BootTime boot_now() {
  BootTime now;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), now.boot);
  timespec since{};
  clock_gettime(CLOCK_BOOTTIME, &since);
  now.s = static_cast<double>(since.tv_sec) + 1e-9 * static_cast<double>(since.tv_nsec);
  return now;
}

std::int64_t MonotonicClock::now_ns() const {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * ns_per_s + now.tv_nsec;
}

void MonotonicClock::sleep_until_ns(std::int64_t time_ns) {
  const timespec until{static_cast<time_t>(time_ns / ns_per_s), static_cast<long>(time_ns % ns_per_s)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace spindle_twin::firmware

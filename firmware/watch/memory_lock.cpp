#include "firmware/watch/memory_lock.hpp"

#include <spdlog/spdlog.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace spindle_twin::firmware {

rlim_t lockable_bytes() {
  rlimit limit{};
  return getrlimit(RLIMIT_MEMLOCK, &limit) == 0 ? limit.rlim_cur : 0;
}

bool lock_memory(rlim_t lockable_bytes) {
  // Under a finite limit some later page would be one too many: an allocation that fails.
  if (lockable_bytes != RLIM_INFINITY) return false;
  // Pages when they are touched: whole stacks of all threads would be more than a unit allows.
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    spdlog::warn("memory cannot be locked: {}", std::strerror(errno));
    return false;
  }
  spdlog::info("memory locked");
  return true;
}

}  // namespace spindle_twin::firmware

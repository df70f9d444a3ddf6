#include "firmware/watch/memory_lock.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <fstream>
#include <string>

namespace spindle_twin::firmware {
namespace memory_lock_test {

long locked_kB() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmLck:") continue;
    long locked = 0;
    status >> locked;
    return locked;
  }
  return -1;
}

TEST(MemoryLock, without_a_limit_what_was_touched_stays_in_memory) {
  // Sanitizers replace mlockall by a call that only says it did.
  if (mlockall(MCL_CURRENT | MCL_ONFAULT) != 0 || locked_kB() == 0) GTEST_SKIP() << "memory cannot be locked here";
  munlockall();
  ASSERT_EQ(locked_kB(), 0);
  EXPECT_TRUE(lock_memory(RLIM_INFINITY));
  EXPECT_GT(locked_kB(), 1000);
  munlockall();
}

TEST(MemoryLock, what_may_be_locked_is_what_the_system_says) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_MEMLOCK, &limit), 0);
  EXPECT_EQ(lockable_bytes(), limit.rlim_cur);
}

TEST(MemoryLock, under_a_limit_nothing_is_locked) {
  EXPECT_FALSE(lock_memory(8U << 20U));
  EXPECT_EQ(locked_kB(), 0);
}

}  // namespace memory_lock_test
}  // namespace spindle_twin::firmware

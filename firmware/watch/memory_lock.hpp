#pragma once

#include <sys/resource.h>

namespace spindle_twin::firmware {

/// How many bytes this process may lock; RLIM_INFINITY with `LimitMEMLOCK=infinity` of the unit.
rlim_t lockable_bytes();

/// Where all memory may be locked, no page that this process has touched leaves it any more, so that no cycle waits for
/// a disk; the log says so. Under a finite limit nothing happens. True: locked. Not in the cycle.
bool lock_memory(rlim_t lockable_bytes);

}  // namespace spindle_twin::firmware

#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

namespace spindle_twin::firmware {

/// Does `work` until it returns by itself. Where it throws, one line of the log says so (three a minute at most) and
/// after `pause` it is begun again, unless `stop` was set meanwhile: what one thread could not foresee ends neither the
/// process nor other spindles. `what` names the thread in that line. `work` must be able to begin anew; not for the
/// cycle, whose state would be nobody's afterwards.
void keep_running(const std::string& what, const std::atomic<bool>& stop, const std::function<void()>& work,
                  std::chrono::milliseconds pause = std::chrono::seconds(1));

}  // namespace spindle_twin::firmware

#pragma once

#include <cstddef>

namespace spindle_twin::correction {

/// How a growth was measured.
enum class ReadingOrigin {
  touch_off,           ///< a length that the PLC or the live page handed to the daemon
  by_hand,             ///< the growth itself: a probe, an uncompensated part
  by_hand_compensated  ///< what was left of it while the control compensated: a part
};

/// One measured growth of an output beside what the twin had published before it knew of it, m. Zeros are unknown:
/// only differences within one stretch and origin count.
struct GrowthReading {
  double unix_s = 0.0;
  std::size_t stretch = 0;  ///< from a start or a tare to the next one
  ReadingOrigin origin = ReadingOrigin::touch_off;
  double measured_m = 0.0;
  double predicted_m = 0.0;
};

}  // namespace spindle_twin::correction

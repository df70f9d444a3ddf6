#pragma once

#include <cmath>
#include <cstddef>

namespace spindle_twin::correction {

/// No spindle grows by more: what is larger was typed or scaled wrongly.
inline constexpr double largest_growth_um = 10000.0;
/// Deviations that a measured length can have: less measures nothing, more tells nothing.
inline constexpr double least_growth_deviation_um = 0.01, most_growth_deviation_um = 1000.0;

/// Whether a measured growth and its standard deviation can be what they are said to be: numbers, a growth of at most
/// largest_growth_um, a deviation within its limits. May run in the cycle.
inline bool is_growth(double growth_m, double deviation_m) {
  constexpr double um = 1e-6, rounding = 1.0 + 1e-6;  // registers hold single precision
  return std::abs(growth_m) <= largest_growth_um * um * rounding &&
         deviation_m * rounding >= least_growth_deviation_um * um &&
         deviation_m <= most_growth_deviation_um * um * rounding;
}

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

#pragma once

#include <string>
#include <vector>

#include "correction/calibrate/thermal_test.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// Readings of one channel that stand alone, as the test has them no more.
struct Spikes {
  std::string channel;
  int readings = 0;
  double first_s = 0.0;  ///< time of the first in the test
};

/// Takes out of a test what stands alone among its neighbours (Hampel's filter, J. Amer. Stat. Ass. 69, 1974): with m
/// the median of a reading x, the three before it and the three after it of its own channel,
///   |x − m| > max(least, 6 · 1.4826 · median |neighbour − m|),   least 0.3 K of a sensor, ten deviations of a probe's
/// noise. A mean over a minute would hand it on, and what is left of it would speak against a good fit. Steps, slow or
/// at once, stay: three neighbours are beyond them. Channels without such a reading are not in the result.
std::vector<Spikes> leave_out_spikes(const rom::Network& network, double probe_noise_m, correction::ThermalTest& test);

}  // namespace spindle_twin::host_tools

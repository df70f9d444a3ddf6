#pragma once

#include <cstdint>
#include <limits>

namespace spindle_twin::correction {

enum class HealthState : std::uint8_t {
  good,       ///< its readings are used
  suspect,    ///< this reading is withheld, the channel is not judged yet
  failed,     ///< no reading is used until the fault has gone
  returning,  ///< the fault has gone; on probation, not used yet
};

/// Why a channel is not good.
enum class HealthFault : std::uint8_t {
  none,
  open,          ///< at or above open_above_K
  shorted,       ///< at or below short_below_K
  out_of_range,  ///< outside the channel's own range
  jump,          ///< left its course at once and stays away
  spikes,        ///< single readings far from its course, too many of them
  stuck,         ///< does not move while the model does
  drift,         ///< leaves slowly; stays failed until acknowledged
  swapped,       ///< shows another channel's temperature; stays failed until acknowledged
  implausible,   ///< contradicts all others, and came too fast for a drift
};

/// What is published of a channel.
struct HealthRecord {
  HealthState state = HealthState::good;
  HealthFault fault = HealthFault::none;   ///< the last one, kept while not good
  bool usable = false;                     ///< this reading may be used
  bool returned = false;                   ///< became good again with this sample: its offset is not known any more
  double return_offset_deviation_K = 0.0;  ///< then: 1σ of its offset
  int partner = -1;                        ///< of a swapped channel
  bool read_for_partner = false;           ///< then: this reading may be used for the partner's place
  int failures = 0;                        ///< since the start or the acknowledgement
  int spikes = 0;                          ///< since the start
  double since_s = 0.0;                    ///< time of the last change of state
};

/// What of a channel outlives a restart.
struct KeptHealth {
  HealthFault fault = HealthFault::none;  ///< that it is out for; none: it is in use
  bool latched = false;                   ///< out until acknowledged
  int partner = -1;
  int failures = 0;
  bool read_for_partner = false;  ///< until acknowledged
  /// Reading − prediction while its readings were used, NaN where none were, and how long ago that was.
  double usual_offset_K = std::numeric_limits<double>::quiet_NaN();
  double used_before_s = 0.0;
};

}  // namespace spindle_twin::correction

#pragma once

#include "firmware/cycle/snapshot.hpp"
#include "tests/bench/reality/families.hpp"

namespace spindle_twin::bench {

/// Two sensors, drawn for each spindle, are unplugged after so long and come back in each other's places or in their
/// own.
struct Unplugging {
  double for_s = 0.0;  ///< 0: none
  bool exchanged = true;

  static constexpr double back_s = 3600.0;
};

/// What data-acquisition device and PLC say of a truth: noise, offsets, lag, gaps, exchanged wires.
class MachineSide {
 public:
  MachineSide(const RealityTruth& truth, const Family& family, const Unplugging& unplugging);

  /// Goes on to time_s, which must not fall.
  void tell(double time_s);
  const firmware::DeviceFrame& frame() const { return frame_; }
  const firmware::PlcCommand& command() const { return command_; }

  /// The two that are unplugged.
  const std::array<std::size_t, 2>& pair() const { return pair_; }
  /// Whether this sensor is broken, or wired wrongly by now.
  bool is_faulty(std::size_t sensor) const;

 private:
  struct Gap {
    double from_s = 0.0;
    double until_s = 0.0;
  };
  void draw_gaps();
  bool in_gap(double time_s) const;
  bool is_of_pair(std::size_t sensor) const { return sensor == pair_[0] || sensor == pair_[1]; }
  bool is_pair_exchanged(double time_s) const;
  bool is_silent(std::size_t sensor, double time_s) const;
  void read_sensors(double time_s);
  void read_signals(double time_s);
  void touch_off(double time_s);

  const RealityTruth& truth_;
  const Family& family_;
  Unplugging unplugging_;
  std::array<std::size_t, 2> pair_{};
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  std::array<double, sensor_count> offset_K_{};
  std::array<std::size_t, sensor_count> place_{};
  std::array<double, sensor_count> lagged_K_{};
  double drift_sign_ = 1.0;
  std::vector<Gap> gaps_;
  double read_s_ = -1.0;
  double touched_s_ = 0.0;
  firmware::DeviceFrame frame_;
  firmware::PlcCommand command_;
};

}  // namespace spindle_twin::bench

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <random>
#include <string>

#include "correction/health/record.hpp"

namespace spindle_twin::bench {

/// The ways in which a sensor fails; withdrawn: it is not used any more, nor its partner in withdrawn_pair; replugged:
/// two are unplugged and come back in their places.
enum class FaultKind {
  none,
  withdrawn,
  withdrawn_pair,
  open,
  shorted,
  out_of_range,
  jump,
  spikes,
  stuck,
  swapped,
  drift,
  replugged
};
inline constexpr std::array all_faults{FaultKind::open,    FaultKind::shorted, FaultKind::out_of_range,
                                       FaultKind::jump,    FaultKind::spikes,  FaultKind::stuck,
                                       FaultKind::swapped, FaultKind::drift};

const char* name_of(FaultKind kind);

/// What two sensors read before they come back.
struct Unplugged {
  double for_s = 0.0;            ///< none for so long,
  double partner_later_s = 0.0;  ///< the partner for so much longer
  bool reads_open = false;       ///< or what an input says of a broken wire
  bool daemon_off = false;       ///< for for_s, and then goes on from its checkpoint
};

struct Fault {
  FaultKind kind = FaultKind::none;
  int sensor = 0;
  int partner = 0;  ///< of swapped sensors
  Unplugged unplugged;
  double from_s = 0.0;
  double until_s = 1e18;
  double size_K = 0.0;        ///< of a jump or a spike, with its sign
  double rate_K_per_s = 0.0;  ///< of a drift
  bool is_reference() const { return kind == FaultKind::withdrawn || kind == FaultKind::withdrawn_pair; }
  /// Whether the fault is one of this sensor.
  bool concerns(int which) const {
    const bool both = kind == FaultKind::swapped || kind == FaultKind::withdrawn_pair;
    return kind != FaultKind::none && (which == sensor || (both && which == partner));
  }
  bool is_unplugged(int which, double time_s) const {
    const double later_s = which == partner ? unplugged.partner_later_s : 0.0;
    return (which == sensor || which == partner) && time_s >= from_s - unplugged.for_s && time_s < from_s + later_s;
  }
  bool is_daemon_off(double time_s) const {
    return unplugged.daemon_off && time_s >= from_s - unplugged.for_s && time_s < from_s;
  }
  bool at(double time_s) const { return kind != FaultKind::none && time_s >= from_s && time_s < until_s; }
};

/// What a fault makes of the readings, sample by sample.
class Saboteur {
 public:
  Saboteur(const Fault& fault, std::uint64_t seed) : fault_(fault), random_(seed) {}
  void tamper(double time_s, Eigen::VectorXd& readings_K);

 private:
  void tamper_now(double time_s, Eigen::VectorXd& readings_K);
  void unplug(double time_s, Eigen::VectorXd& readings_K) const;

  Fault fault_;
  std::mt19937_64 random_;
  double held_K_ = 0.0;
  bool holding_ = false;
};

}  // namespace spindle_twin::bench

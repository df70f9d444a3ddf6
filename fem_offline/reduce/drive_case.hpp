#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "fem_offline/reduce/parameter_box.hpp"
#include "rom/boundaries.hpp"

namespace spindle_twin::fem_offline {

/// Inputs that are held for a while; outputs are compared at its end.
struct HeldInterval {
  double duration_s = 0.0;
  rom::OperatingState state;
  Eigen::VectorXd conductance_factors;  ///< empty: those of the case
  double since_jump_s = 0.0;            ///< time from the last change of speed, load, coolant or flow to its start
};

/// A random hour or two of a spindle's life with parameters anywhere in the box.
struct DriveCase {
  rom::CorrectionFactors factors;
  double initial_temperature_K = 0.0;  ///< uniform
  std::vector<HeldInterval> intervals;
};

/// Start and surroundings of a case lie so far from the datum and from the operating state, coolants' steps included.
inline constexpr double drive_spread_K = 5.0;
/// Ambients drift up to so far from there until the end of the longest case.
inline constexpr double drive_drift_K = 12.0;

/// Intervals double from 1 s after a change to this: what follows a change slowly also errs slowly.
inline constexpr double longest_interval_s = 128.0;
/// The same where contacts and films drift: they are held over an interval.
inline constexpr double longest_drift_interval_s = 32.0;
/// A contact or film that drifts changes by no more than a factor of two in this time.
inline constexpr double drift_doubling_s = 600.0;

struct CaseOptions {
  ParameterBox box;
  bool drift = false;  ///< contacts and films move during the run
};

/// Case `index` of `seed`, a function of these and the options alone: contacts log-uniform 0.1 to 10, films 0.2 to 5; 1
/// to 2 h in segments of 60 to 900 s, each with a new speed (a quarter of them at rest), load and coolant flow; coolant
/// steps of up to ±5 K at every third segment; ambient that drifts by up to ±6 K/h. Intervals are 1, 1, 2, 4, 8, 16 s
/// and so on long after every segment's start, then longest_interval_s.
/// With drift every conductance's logarithm goes up and down within the box, at a new rate of up to ±ln 2 per
/// drift_doubling_s from every segment on.
DriveCase random_case(const rom::Boundaries& boundaries, std::uint64_t seed, std::uint32_t index,
                      const CaseOptions& options = {});

}  // namespace spindle_twin::fem_offline

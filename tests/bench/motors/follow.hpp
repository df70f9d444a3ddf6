#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/cycle/snapshot.hpp"
#include "rom/network.hpp"
#include "tests/bench/motors/motor.hpp"

namespace spindle_twin::bench {

constexpr double run_s = 4.0 * 3600.0;
constexpr double judged_from_s = 20.0 * 60.0;
constexpr std::array<const char*, 2> place_names{"winding", "housing"};

enum class Start { cold, warm, warm_stopped };  // stopped: some minutes before the twin starts
const char* name_of(Start start);

/// A motor through a run, and what its two sensors say. Entry i of the inputs holds from i periods on.
struct MotorRun {
  std::uint64_t seed = 0;
  Start start = Start::cold;
  int bodies = 0;
  double period_s = 1.0;
  std::vector<MotorInputs> inputs;
  Eigen::MatrixXd truth_K;     ///< 2 x (periods + 1): winding, housing
  Eigen::MatrixXd readings_K;  ///< 2 x periods
};

/// Samples are 1 to 5 s apart; noise 0.05 K, constant errors of 0.2 K (1 sigma).
MotorRun run_motor(Motor motor, Start start, std::uint64_t seed);

/// Same with a constant rated duty from the first second on, as long as it lasts; before, likewise for two hours.
MotorRun run_motor_at_rated_duty(Motor motor, std::uint64_t seed);

struct PlaceScore {
  double rms_K = 0.0;  ///< of the prediction against the true temperature, as all of these from judged_from_s on
  double worst_K = 0.0;
  double worst_early_K = 0.0;  ///< from two minutes on until then
  double within_1_K = 0.0;     ///< share
  double inside = 0.0;         ///< share of the truth within two published deviations
  double deviation_K = 0.0;    ///< published, rms
  double uncorrected_K = 0.0;  ///< rms error of the model without correction
};

struct FollowScore {
  std::array<PlaceScore, 2> places;
  double degraded = 0.0;  ///< share of the time
  double failed = 0.0;    ///< share of the time in which a fed sensor counted as failed
  double rejected = 0.0;  ///< share of the last updates' readings that were rejected
  bool ended_running = false;
  double rejecting_unsaid = 0.0;  ///< share of the windows of ten minutes with most readings rejected and `running`
};

struct FollowOptions {
  std::string correction;  ///< lines for the daemon's table [correction]
  std::string health;      ///< and for [health]
  std::string trace_path;  ///< empty: none; a run appends to it
  const char* label = "";  ///< of the trace's rows
};

/// The daemon's cycle follows the run with the sensors that are fed: plan and defaults are those that the daemon makes
/// of its configuration file for a hand-written network.
FollowScore follow(const rom::Network& network, const MotorRun& run, const std::array<bool, 2>& fed,
                   const FollowOptions& options);

}  // namespace spindle_twin::bench

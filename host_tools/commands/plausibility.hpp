#pragma once

#include <CLI/App.hpp>
#include <Eigen/Core>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "firmware/cycle/plan.hpp"
#include "host_tools/replay/log.hpp"
#include "rom/boundary_values/plausible_inputs.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/network.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {

/// What a command does with what is not believed: one warning per field on stderr, or with --strict the first as an
/// rom::InputError.
class Plausibility {
 public:
  /// Adds --strict.
  void add_to(CLI::App& command);
  /// `where`: the file that says it, with its line where it has one.
  void note(const rom::SourceLine& where, const std::vector<rom::Implausible>& found);
  /// Of every row; `path` is the schedule's.
  void note_schedule(const std::string& path, const rom::Schedule& schedule, const rom::Boundaries& boundaries,
                     double certified_rpm = 0.0);
  /// Of every row of a machine's log.
  void note_log(const Log& log, const rom::Network& network);
  /// Of every reading of a sensor that the plan has, beyond its range.
  void note_readings(const Log& log, const rom::Network& network, const firmware::CyclePlan& plan);
  /// Of the coldest and the hottest reading of any sensor, as of a run's temperatures.
  void note_measured(const Log& log, const rom::Network& network);
  /// Of what came out at one instant of a run. With --strict an error at once; else warned of at the run's end.
  void add_temperatures(const std::string& file, const rom::Boundaries& boundaries, const Eigen::VectorXd& nodes_K);
  /// The end of the run: warns of the hottest and the coldest of all instants.
  void note_temperatures(const std::string& file, const rom::Boundaries& boundaries);
  /// Something was warned of.
  bool has_warned() const { return !said_.empty(); }

 private:
  bool strict_ = false;
  std::set<std::string> said_;
  double coldest_K_ = std::numeric_limits<double>::infinity();
  double hottest_K_ = 0.0;
};

}  // namespace spindle_twin::host_tools

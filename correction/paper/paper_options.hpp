#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "correction/paper/rise_ratio.hpp"
#include "rom/network.hpp"
#include "rom/option.hpp"

namespace spindle_twin::correction {

/// Why the last correction instant changed nothing. The number is what a status register publishes.
enum class Freeze : std::uint16_t {
  none = 0,
  waiting = 1,            ///< the first period has not passed
  too_few_sensors = 2,    ///< fewer valid sensors over the whole window than PaperGuards::minimum_sensors
  operating_changed = 3,  ///< speed or load changed within PaperGuards::settle_s
  standstill = 4,         ///< no heat to be seen
  small_rise = 5,         ///< a rise below max(10 u, minimum_rise_K)
  negative_ratio = 6,     ///< ratio <= 0 or not finite
  deadband = 7,           ///< |ln ratio| below u / rise: nothing to correct
  at_limit = 8,           ///< the cumulative limit is reached and the ratio points beyond it
  base_failed = 9,        ///< the base response could not be integrated
};

/// Sensors that judge and sources that follow one common factor.
struct HeatGroup {
  std::string name;
  std::vector<int> key_points;  ///< indices into Network::key_points
  std::vector<int> sources;     ///< indices into Boundaries::sources; a source is in one group at most
};

/// One group, all key points, all sources.
std::vector<HeatGroup> common_heat_group(const rom::Network& network);

/// Options, not state: what a person may set, which is why it is open. `each` says what each means.
struct PaperGuards {                    // NOLINT(public-members): a table of options, which `each` names one by one
  double reading_uncertainty_K = 0.03;  ///< u of a window mean against the base
  double minimum_rise_K = 0.3;
  double step_minimum = 0.8;
  double step_maximum = 1.25;
  double heat_minimum = 0.2;
  double heat_maximum = 5.0;
  double resistance_minimum = 0.1;
  double resistance_maximum = 10.0;
  double resistance_step = 1.25;
  int minimum_sensors = 2;  ///< never more than the group has
  double settle_s = 80.0;
  double speed_change_rpm = 50.0;
  double load_change = 0.05;
  double standstill_rpm = 1.0;
  bool deadband = true;

  template <class Options, class Visit>
  static void each(Options& guards, Visit&& visit) {
    constexpr rom::Range below_1{0.0, 1.0, false, true}, above_1{1.0, 1e6, true, false};
    visit({"reading_uncertainty_K", "of zeroed sensors", rom::not_negative}, guards.reading_uncertainty_K);
    visit({"minimum_rise_K", "and ten times the uncertainty", rom::not_negative}, guards.minimum_rise_K);
    visit({"step_minimum", "of one correction of the heat", below_1}, guards.step_minimum);
    visit({"step_maximum", "", above_1}, guards.step_maximum);
    visit({"heat_minimum", "of all corrections together, times the description's heat", below_1}, guards.heat_minimum);
    visit({"heat_maximum", "", above_1}, guards.heat_maximum);
    visit({"resistance_minimum", "the same of a contact's resistance", {0.001, 1.0, false, true}},
          guards.resistance_minimum);
    visit({"resistance_maximum", "", above_1}, guards.resistance_maximum);
    visit({"resistance_step", "of one correction, up or down", above_1}, guards.resistance_step);
    visit({"minimum_sensors", "valid over the whole window", rom::between(1.0, 1e6)}, guards.minimum_sensors);
    visit({"settle_s", "no correction so long after a change of speed or load by", rom::not_negative}, guards.settle_s);
    visit({"speed_change_rpm", "", rom::not_negative}, guards.speed_change_rpm);
    visit({"load_change", "", rom::not_negative}, guards.load_change);
    visit({"standstill_rpm", "", rom::not_negative}, guards.standstill_rpm);
    visit({"deadband", "no correction within the sensors' uncertainty"}, guards.deadband);
  }
};

/// Likewise.
struct PaperOptions {
  double period_s = 80.0;     ///< between corrections
  double window_s = 10.0;     ///< measured and model are averaged alike over it; 0: one sample
  double relaxation = 1.0;    ///< gamma in Q' = Q ratio^gamma
  bool state_rescale = true;  ///< multiply the model's rise above the base by the same factor (see rescaled_nodes_K)
  bool heat_law = true;
  bool joint_law = true;
  double joint_exponent = 0.68;
  RatioForm form = RatioForm::consistent;
  std::vector<HeatGroup> groups;  ///< empty: common_heat_group
  PaperGuards guards;

  template <class Options, class Visit>
  static void each(Options& options, Visit&& visit) {
    visit({"period_s", "", {0.0, 86400.0, true, false}}, options.period_s);
    visit({"window_s", "averaged at the end of each period", rom::between(0.0, 86400.0)}, options.window_s);
    visit({"relaxation", "0 (excluded) to 1", {0.0, 1.0, true, false}}, options.relaxation);
    visit({"state_rescale", "corrects the state with the heat, which keeps the law from ringing"},
          options.state_rescale);
    visit({"heat_law", ""}, options.heat_law);
    visit({"joint_law", ""}, options.joint_law);
    visit({"joint_exponent", "", rom::between(0.0, 1.0)}, options.joint_exponent);
  }
};

/// What the cycle hands over at time_s: all of the same instant, one entry per Network::key_points.
struct PaperSample {
  double time_s = 0.0;
  const Eigen::VectorXd& measured_K;
  const Eigen::Array<bool, Eigen::Dynamic, 1>& valid;
  const Eigen::VectorXd& predicted_K;
  const Eigen::VectorXd& nodes_K;
  const rom::OperatingState& operating;
};

}  // namespace spindle_twin::correction

#pragma once

#include <Eigen/Core>
#include <vector>

#include "correction/paper/measuring_window.hpp"
#include "correction/paper/paper_options.hpp"
#include "rom/boundaries.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// Contact resistance of an interference fit relative to assembly,
///   R'/R = (1 + dP/P0)^-exponent,  dP = pressure_per_inner_rise · inner_rise − pressure_per_outer_rise · outer_rise,
/// so a hotter inner body presses harder and conducts better. This is the paper's correction with the two
/// defects taken out that make it singular at zero rise and let the resistance only grow.
/// Where the pressure would fall to nothing the result is `maximum`; it is kept inside [minimum, maximum]. Cycle-safe.
double joint_resistance_ratio(const rom::JointFit& fit, double inner_rise_K, double outer_rise_K, double exponent,
                              double minimum, double maximum);

/// The joint law: one factor on each contact with a fit, from the mean rises of its two bodies since assembly, the
/// model's part means shifted by the mean residual of the sensors on that part. No allocation after construction; may
/// run in the cycle.
class JointLaw {
 public:
  /// `network` must outlive this.
  explicit JointLaw(const rom::Network& network);

  /// Moves the factors of the contacts, each by guards.resistance_step at most. Whether one moved.
  bool correct(const PaperOptions& options, const MeasuringWindow& window, const Eigen::VectorXd& nodes_K,
               rom::CorrectionFactors& factors);

 private:
  void shift_parts_by_sensors(const MeasuringWindow& window);
  /// Mean rise of a part since assembly.
  double rise_K(int part, const Eigen::VectorXd& nodes_K) const;

  const rom::Network* network_;
  std::vector<int> part_of_key_point_;  ///< -1: of none
  Eigen::VectorXd part_shift_K_;
  Eigen::VectorXi part_sensors_;
};

}  // namespace spindle_twin::correction

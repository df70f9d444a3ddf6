#pragma once

#include <memory>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "correction/estimator/sensitivities.hpp"
#include "correction/estimator/sensor_window.hpp"
#include "correction/estimator/square_root_filter.hpp"

namespace spindle_twin::correction {

/// So long after a start the sensitivities are carried on in every cycle: all that is not known comes into play then.
constexpr double fresh_s = 30.0;

/// The inside of EstimatorCorrection, whose members are described there.
struct EstimatorCore {
  EstimatorCore(const rom::Network& the_network, EstimatorOptions the_options);

  void reset(double time_s, const Eigen::VectorXd& nodes, const rom::OperatingState& operating);
  EstimatorStep step(const EstimatorSample& sample);
  void stand_by(double time_s, const Eigen::VectorXd& nodes, const rom::OperatingState& operating);
  void note_displacement(int index, double value_m, double deviation_m);
  void widen_offset(Eigen::Index sensor, double deviation_K);
  void widen_start(double time_s, const Eigen::VectorXd& nodes, const Eigen::VectorXd& rise_K);
  void note_tare(Eigen::Index sensor, double shift_K, double deviation_K);
  void passing_of_time(double elapsed_s, Eigen::VectorXd& to_keep, Eigen::VectorXd& to_grow) const;
  void adopt(const SquareRootFilter& other, const rom::OperatingState& operating);
  void save(EstimatorState& state) const;
  bool restore(const EstimatorState& state);

 private:
  void forget();
  void publish_factors(const rom::OperatingState& operating);
  /// A held period: from here on S is owed, until close_period() pays it with the model's temperatures at both ends.
  void open_period(double time_s, const rom::OperatingState& operating);
  void close_period(double time_s);
  void pass_time(double elapsed_s);
  void note_bend();
  /// κ ½ Σ (s_i P_ii)² over the ln factors: what a row of S leaves out because outputs are not linear in them.
  double curvature_variance(const Eigen::VectorXd& sensitivity) const;
  /// Sets `to` and takes the innovation in unless the gate rejects it.
  void fuse(SensorRecord& to, double innovation, double noise);
  void fuse_sensor(Eigen::Index s, double time_s);
  void fuse_displacement();
  void fuse_tares();
  bool update(double time_s);
  /// θ from the filter, within its limits, and the state with it. Whether θ moved.
  bool follow_filter();

 public:
  const rom::Network& network;
  EstimatorOptions options;
  std::shared_ptr<const rom::NetworkOperator> shared;
  ParameterModel parameters;
  Sensitivities sensitivities;
  DeviationOfOutputs outputs;
  SquareRootFilter filter, prior;
  EstimatorUpdate last_update;
  Eigen::VectorXd prior_mean, neutral_mean, keep, growth, row;
  Eigen::MatrixXd prior_covariance, prior_root;
  Eigen::VectorXd theta, theta_before, theta_step;
  rom::CorrectionFactors factors;
  Eigen::VectorXd bias_K, rises_K;
  rom::BoundaryValues values;
  rom::OperatingState held_state, corrected_state;
  Eigen::VectorXd tare_deviation_K;  // of the sensors that wait for fuse_tares(); 0: none
  Eigen::VectorXd start_K, nodes_K, corrected_K;
  std::vector<SensorWindow> windows;
  std::vector<Eigen::VectorXd> displacement_rows;
  Eigen::VectorXd displacement_row;
  Eigen::VectorXd bend;  ///< √(κ/2) P_ii of the ln factors, of the start what its effect may miss, 0 for the rest
  SensorRecord displacement_record;
  int displacement_index = 0;
  double displacement_m = 0.0, displacement_variance_m2 = 1.0;
  double opened_s = 0.0, fused_s = 0.0, due_s = 0.0, seen_s = 0.0, fresh_until_s = 0.0;
  // Of a start after a pause: > 0, its parameter forgets; what its effect may miss, when it was widened.
  double start_memory_s = 0.0, start_shape = 0.0, widened_s = 0.0;
  bool started = false, period_open = false, standing_by = false, displacement_pending = false;
  long updates = 0, failures = 0;
};

}  // namespace spindle_twin::correction

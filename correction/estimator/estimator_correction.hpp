#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "correction/estimator/output_deviations.hpp"
#include "correction/estimator/parameters.hpp"
#include "correction/estimator/square_root_filter.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// A temperature sensor as the estimator sees it.
struct EstimatorSensor {
  std::string name;
  Eigen::VectorXd row;     ///< N; temperature_K = row · T, entries sum to 1
  double noise_K = 0.03;   ///< 1σ of one reading
  double offset_K = 0.02;  ///< 1σ of its constant error: 0.02 after a tare, 0.2 for a class A PT100 without one
  double lag_s = 0.0;      ///< first-order lag or delay between the temperature and the reading
};

struct EstimatorOptions {
  EstimatorPriors priors;
  double period_s = 10.0;  ///< between updates, [1, 60]
  double noise_K = 0.03;   ///< of the sensors that are made from key points
  double offset_K = 0.02;
  double lag_s = 0.0;
  double floor_K = 0.03;   ///< 1σ of what the network itself is wrong at a sensor
  double curvature = 0.5;  ///< κ, share of what a straight line leaves out of the ln factors that counts; 0: linear
  double correlation_s = 60.0;  ///< errors closer than this in time count as one
  double offset_walk_K_per_root_hour = 0.002;
  double gate = 5.0;                     ///< an innovation beyond so many deviations is rejected
  std::vector<EstimatorSensor> sensors;  ///< empty: one per key point of the network
};

/// One sensor per key point, with the options' noise, offset and lag.
std::vector<EstimatorSensor> key_point_sensors(const rom::Network& network, const EstimatorOptions& options);

/// What the last update made of a channel.
struct SensorRecord {
  double observation_K = 0.0;  ///< mean of the valid readings since the update before; NaN without one
  double innovation_K = 0.0;   ///< observation − prediction − offset, before this channel was fused
  double variance_K2 = 0.0;    ///< expected of the innovation
  double test_ratio = 0.0;     ///< innovation² / (gate² variance): above 1 it is rejected
  bool rejected = false;
  bool fused = false;
  double offset_K = 0.0;
  double offset_deviation_K = 0.0;
  int rejected_in_a_row = 0;
};

/// Readings and model at time_s; measured_K and valid have one entry per sensor of the estimator.
struct EstimatorSample {
  double time_s = 0.0;
  const Eigen::VectorXd& measured_K;
  const Eigen::Array<bool, Eigen::Dynamic, 1>& valid;
  const Eigen::VectorXd& nodes_K;
  const rom::OperatingState& operating;  ///< as read, without environment_bias_K()
};

struct EstimatorStep {
  bool corrected = false;        ///< factors() or environment_bias_K() changed by an update
  bool state_corrected = false;  ///< the caller sets its stepper to corrected_nodes_K() before it integrates on
};

/// A parameter as it is known now. Above 0.9 of its prior deviation the present sensors say nothing of it.
struct ParameterEstimate {
  double value = 0.0;
  double deviation = 0.0;
  double prior_deviation = 0.0;
  bool undetermined() const { return deviation > 0.9 * prior_deviation; }
};

/// What an update was made from, for other filters over the same (θ, b) that see the same readings.
struct EstimatorUpdate {
  double elapsed_s = 0.0;       ///< since the update before
  Eigen::VectorXd theta;        ///< before it; residuals and rows hold there
  Eigen::MatrixXd rows;         ///< p x sensors: sensitivity of each prediction
  Eigen::VectorXd residual_K;   ///< mean of reading − prediction, offset included; NaN without a valid reading
  Eigen::VectorXd noise_K2;     ///< variance of the residual besides that of (θ, b)
  double displacement_m = 0.0;  ///< reading − prediction of a touch-off; NaN without one
  double displacement_variance_m2 = 0.0;
  Eigen::VectorXd displacement_row;  ///< p
};

/// All that the estimator remembers; plain numbers, for a checkpoint. Its sizes depend on network and options.
struct EstimatorState {
  std::vector<double> mean, root, sensitivities, lagged;
};

/// The estimator: a filter over parameters θ (ln factors of heats, contacts and films, environment biases, bearing
/// temperature coefficient, speed exponents) and sensor offsets b, that corrects state and parameters together.
/// With S = dx/dθ carried along (sensitivities.hpp) and P the covariance of (θ, b) (square_root_filter.hpp):
///   every period       P += walk,  H = [L_s S, 1_s],  v = y − L_s T − b
///   per sensor         r = (noise²/n + floor² + curvature ½ Σ (h_i P_ii)²) max(1, 60 s / interval)
///                      (θ, b) += K v,  P ← P − K h P          if v² <= gate² (h P hᵀ + r)
///   then               x += S Δθ: what the wrong parameters have done to the state is taken back with them
///   every cycle        heat factors = e^θ (|n|/n_ref)^δ e^(−β rise), conductance factors = e^θ
/// The model itself is the caller's: it integrates with factors() and with environment_bias_K() added to what the
/// environments read. step() may run in the cycle: no allocation, at most one propagation of S a cycle and one update
/// a period.
class EstimatorCorrection {
 public:
  /// `network` must outlive this. Throws rom::InputError naming the option for one out of range.
  EstimatorCorrection(const rom::Network& network, EstimatorOptions options);
  ~EstimatorCorrection();
  EstimatorCorrection(EstimatorCorrection&&) noexcept;
  EstimatorCorrection& operator=(EstimatorCorrection&&) noexcept;

  /// Starts anew at time_s from these nodes, which count as known: no sensitivities, priors, offsets zero.
  void reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating);

  /// Takes the sample at time_s, updates if a period has passed, and sets the factors for the coming advance_s.
  /// The first call resets by itself.
  EstimatorStep step(const EstimatorSample& sample, double advance_s);

  /// Instead of step() while the correction is switched off and the caller's model runs with all factors 1 and no
  /// biases. Factors go to 1, what was learnt is given up, and the sensitivities are carried on: the first update after
  /// switching on knows what the uncorrected heats have done. Switching moves no temperature.
  void stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating, double advance_s);

  /// A touch-off or a reading of a displacement probe: deformation output `index`, counted from the reference
  /// temperature. It is taken in with the next update, gated like a sensor. deviation_m > 0.
  void note_displacement(int index, double value_m, double deviation_m);

  /// The sensor's offset may have changed by so much (1σ) since it was last used: what comes next of it teaches its
  /// offset before anything else. For a sensor that returns after a fault. May run in the cycle.
  void widen_offset(Eigen::Index sensor, double deviation_K);

  /// Before the first step after a pause: unseen heating may have made the spindle warmer than these nodes, if it went
  /// on all the time by rise_K (N). From here on the start parameter means that: half of it is 1σ. For some ten minutes
  /// it stays open and a fifth of it counts as unknown besides, in readings and outputs alike, because heat that came
  /// and went in another way has another shape. Nothing happens without a start parameter. Allocates.
  void widen_start(double time_s, const Eigen::VectorXd& nodes_K, const Eigen::VectorXd& rise_K);

  const EstimatorUpdate& last_update() const;
  double gate() const;
  /// The filter over (θ, b), its prior and its passing of time: z ← centre + keep (z − centre), P ← keep P keep +
  /// growth.
  const SquareRootFilter& filter() const;
  const SquareRootFilter& prior() const;
  void passing_of_time(double elapsed_s, Eigen::VectorXd& keep, Eigen::VectorXd& growth) const;
  /// Steps in θ (p x any number, as many in every call) of which one may be true besides: from the next update on
  /// deviations() has room for each.
  void set_alternatives(const Eigen::MatrixXd& steps);
  /// Goes over to another filter of the same (θ, b), the state with it; after step(). The caller then sets its stepper
  /// to corrected_nodes_K().
  void adopt(const SquareRootFilter& other, const rom::OperatingState& operating);

  /// A tare was taken: the sensor's readings are lower by shift_K from now on, and its offset is 0 ± deviation_K, which
  /// the next update takes in. deviation_K > 0.
  void note_tare(Eigen::Index sensor, double shift_K, double deviation_K);

  /// Starts θ at `theta` instead of the priors' mean, everything else as it is.
  void set_parameters(const Eigen::VectorXd& theta);

  const rom::CorrectionFactors& factors() const;
  const Eigen::VectorXd& environment_bias_K() const;
  const Eigen::VectorXd& corrected_nodes_K() const;

  const ParameterModel& parameters() const;
  ParameterEstimate estimate(Eigen::Index parameter) const;
  const std::vector<EstimatorSensor>& sensors() const;
  const SensorRecord& record(Eigen::Index sensor) const;
  /// Of the last displacement, in m.
  const SensorRecord& displacement_record() const;
  /// 1σ of all outputs at the last update; in the first 30 s after reset() at the last step.
  const OutputDeviations& deviations() const;
  /// Covariance of (θ, b). Allocates.
  Eigen::MatrixXd covariance() const;
  /// dT/dθ, N x p. Allocates.
  Eigen::MatrixXd sensitivities_K() const;
  long updates() const;
  /// Periods whose sensitivities could not be carried on; 0 in good health.
  long failures() const;

  /// Sizes `state` on the first call, then cycle-safe.
  void save(EstimatorState& state) const;
  /// After reset() with the nodes of the same instant. False, and nothing changed, where the sizes are not those of
  /// this network and these options or an entry is not finite.
  bool restore(const EstimatorState& state);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::correction

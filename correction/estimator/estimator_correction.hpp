#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "correction/estimator/calibrated_prior.hpp"
#include "correction/estimator/calibration_recall.hpp"
#include "correction/estimator/consistency.hpp"
#include "correction/estimator/estimator_options.hpp"
#include "correction/estimator/held_period.hpp"
#include "correction/estimator/measurement.hpp"
#include "correction/estimator/output_deviations.hpp"
#include "correction/estimator/parameters.hpp"
#include "correction/estimator/reduced_chi_square.hpp"
#include "correction/estimator/sensitivities.hpp"
#include "correction/estimator/sensor_channel.hpp"
#include "correction/estimator/square_root_filter.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

class SecondPass;

/// One sensor per key point, with the options' noise, offset and lag.
std::vector<EstimatorSensor> key_point_sensors(const rom::Network& network, const EstimatorOptions& options);

/// Readings and model at time_s; measured_K and valid have one entry per sensor of the estimator.
struct EstimatorSample {
  double time_s = 0.0;
  const Eigen::VectorXd& measured_K;
  const Eigen::Array<bool, Eigen::Dynamic, 1>& valid;
  const Eigen::VectorXd& nodes_K;
  const rom::OperatingState& operating;  ///< as read, without environment_bias_K()
};

/// A heat that no source explains: into which thermal group, and how much. group -1: there is none.
struct FoundHeat {
  Eigen::Index group = -1;
  double heat_W = 0.0;
  double deviation_W = 0.0;
};

/// How wide unknowns of the day are open, in deviations of their prior.
struct Widths {
  double disturbance = 1.0;  ///< heats that no source explains
  double environment = 1.0;  ///< what environments read wrong
};

struct EstimatorStep {
  bool corrected = false;        ///< factors() or environment_bias_K() changed by an update
  bool state_corrected = false;  ///< the caller sets its stepper to corrected_nodes_K() before it integrates on
};

/// A parameter as it is known now. Above 0.9 of its prior deviation the present sensors say nothing of it, and nothing
/// is known either of a heat that is shut: no reading has spoken for one, so none was looked for.
struct ParameterEstimate {
  double value = 0.0;
  double deviation = 0.0;
  double prior_deviation = 0.0;
  bool shut = false;
  static constexpr double significant = 2.0;  ///< deviations beyond which a value is not zero
  bool undetermined() const { return shut || deviation > 0.9 * prior_deviation; }
};

/// All that the estimator remembers; plain numbers, for a checkpoint. Its sizes depend on network and options.
struct EstimatorState {
  std::vector<double> mean, root, sensitivities, lagged;
  std::vector<double> channels;   ///< per sensor: slope of what it shows by its lag, floor
  std::vector<double> start;      ///< of the start's widening after a pause, and of the unexplained heats
  std::vector<double> scale;      ///< prior deviations that `root` is counted in
  std::vector<double> nominal;    ///< as in KnownParameters
  bool knows_calibration = true;  ///< false: readings have contradicted the machine that was calibrated
  double determined = 0.0;        ///< ReducedChiSquare::determined
};

/// What a state says of the unknowns that are called so, in its order; nothing where sizes do not fit or a number is
/// none. Allocates.
std::optional<KnownParameters> known_from(std::vector<std::string> unknowns, const EstimatorState& state);

/// The estimator: a filter over the unknowns z = (θ, b, τ): parameters θ (ln factors of heats, contacts and films,
/// environment biases, bearing temperature coefficient, speed exponents, heats that no source explains, the start),
/// offsets b and lags τ of the sensors. It corrects state and parameters together.
/// With S = dx/dθ carried along (sensitivities.hpp) and P the covariance of z (square_root_filter.hpp):
///   every period       P += walk,  h = [l S, 1, dy/dτ],  v = y − l T − b
///   per sensor         r = (noise²/n + floor² + min(curvature ½ Σ (h_i P_ii)², 9 v²)) max(1, 60 s / interval)
///   all sensors        consistency: where v² / (h P hᵀ + r) says for a minute that the estimate contradicts its
///                      readings, it is loosened: P to the prior around the present z, the start anew (loosen)
///   per sensor         z += K v,  P ← P − K h P           if v² <= gate² (h P hᵀ + r)
///   then               x += S Δθ: what the wrong parameters have done to the state is taken back with them
///   after a start      the readings since then are gone through again, linearised where they have led (SecondPass)
///   every cycle        heat factors = e^θ (|n|/n_ref)^δ e^(−β rise), conductance factors = e^θ
/// The model itself is the caller's: it integrates with factors() and with environment_bias_K() added to what the
/// environments read. step() may run in the cycle: no allocation, at most one propagation of S a cycle and one update
/// a period.
class EstimatorCorrection {
 public:
  /// `network` must outlive this. `shared`: its operator where others have it already; null: one of its own. Throws
  /// rom::InputError naming the option for one out of range.
  EstimatorCorrection(const rom::Network& network, EstimatorOptions options,
                      std::shared_ptr<const rom::NetworkOperator> shared = nullptr);

  ~EstimatorCorrection();
  EstimatorCorrection(EstimatorCorrection&& other) noexcept;
  EstimatorCorrection& operator=(EstimatorCorrection&& other) noexcept;

  /// Starts anew at time_s from these nodes: priors, no sensitivities but those of the start. Where the first readings
  /// say that the spindle does not stand at these temperatures, the start is opened as far as they do
  /// (open_start()); the start parameters are narrow otherwise.
  void reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating);

  /// Before reset(), or before the first step: the next start begins with what is known of this machine, by the names
  /// of unknowns(), instead of the priors; of what is of the day (environments, start, offsets, heats that no source
  /// explains) nothing is taken. No deviation becomes larger than that of its prior. Gives how many were taken: 0, and
  /// nothing changed, where no name fits or a number is none. Allocates.
  int begin_with(const KnownParameters& known);
  /// Names of the unknowns z: parameters, "offset SENSOR", "lag SENSOR".
  std::vector<std::string> unknowns() const;

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

  /// Somebody else has found that the readings contradict the estimate (health): the next update loosens it. May run in
  /// the cycle.
  void note_contradiction() { contradicted_ = true; }
  /// The factor on a heat, a contact or a film is more than 3 deviations of an unknown machine's prior from its mean,
  /// or at the end of its range: what readings ask for lies more likely elsewhere. May run in the cycle.
  bool is_beyond_belief() const;

  /// Health has found that it was the spindle that changed, and no sensor: the next update opens heats that no source
  /// explains as wide as readings that contradict do. May run in the cycle.
  void note_change() { changed_ = true; }

  /// Heats that no source explains are shut in a certified network until something speaks for one: then they are opened
  /// to open_heat_W() and fade again within hours. May run in the cycle.
  bool heats_are_open() const { return open_.disturbance >= 0.5; }
  double open_heat_W(Eigen::Index group) const;
  /// The surest of them that is further from zero than two of its deviations. May run in the cycle.
  FoundHeat unexplained_heat() const;
  /// Goes over to a filter in which they are open, as adopt() does.
  void open_heats(const SquareRootFilter& other, const rom::OperatingState& operating);
  /// z within the limits of its parameters. May run in the cycle.
  void bound(Eigen::VectorXd& unknowns) const;

  const EstimatorUpdate& last_update() const { return made_; }
  double gate() const { return options_.gate; }
  /// The filter over (θ, b), its prior and its passing of time: z ← centre + keep (z − centre), P ← keep P keep +
  /// growth.
  const SquareRootFilter& filter() const { return filter_; }
  const SquareRootFilter& prior() const { return prior_; }
  void passing_of_time(double elapsed_s, Eigen::VectorXd& keep, Eigen::VectorXd& growth) const {
    passing_of_time(elapsed_s, widths(), keep, growth);
  }
  /// The same for a filter that is not as open as the estimator is at the moment.
  void passing_of_time(double elapsed_s, const Widths& widths, Eigen::VectorXd& keep, Eigen::VectorXd& growth) const;
  Widths widths() const { return {open_.disturbance, open_.environment}; }
  /// Steps in θ (p x any number, as many in every call) of which one may be true besides: from the next update on
  /// deviations() has room for each.
  void set_alternatives(const Eigen::MatrixXd& steps) { outputs_.set_alternatives(steps); }
  /// Goes over to another filter of the same (θ, b), the state with it; after step(). The caller then sets its stepper
  /// to corrected_nodes_K().
  void adopt(const SquareRootFilter& other, const rom::OperatingState& operating);

  /// A tare was taken: the sensor's readings are lower by shift_K from now on, and its offset is 0 ± deviation_K, which
  /// the next update takes in, also when the estimate begins anew or stands by before that. deviation_K > 0.
  void note_tare(Eigen::Index sensor, double shift_K, double deviation_K);

  /// Starts θ at `theta` instead of the priors' mean, everything else as it is.
  void set_parameters(const Eigen::VectorXd& theta);

  const rom::CorrectionFactors& factors() const { return factors_; }
  const Eigen::VectorXd& environment_bias_K() const { return bias_K_; }
  const Eigen::VectorXd& corrected_nodes_K() const { return corrected_K_; }

  const ParameterModel& parameters() const { return parameters_; }
  ParameterEstimate estimate(Eigen::Index parameter) const;
  /// By how much friction heats are warmer than at rest, as the factors follow it: of each source, at the last step.
  const Eigen::VectorXd& source_rises_K() const { return rises_K_; }
  const std::vector<EstimatorSensor>& sensors() const { return options_.sensors; }
  const SensorRecord& record(Eigen::Index sensor) const { return records_.at(static_cast<std::size_t>(sensor)); }
  /// Estimated lag of a sensor, and whether the readings fit the estimate.
  double lag_s(Eigen::Index sensor) const;
  const Consistency& consistency() const { return consistency_; }
  /// How often the estimate was loosened; a bank of filters around it then begins anew.
  long loosened() const { return loosened_; }
  /// How often the estimate has gone over to that of a second pass; such a bank begins anew then too.
  long relinearised() const { return relinearised_; }
  /// Of the last displacement, in m.
  const SensorRecord& displacement_record() const { return displacement_.record; }
  /// 1σ of all outputs at the last update; in the first 30 s after reset() at the last step.
  const OutputDeviations& deviations() const { return outputs_.deviations(); }
  /// Covariance of z. Allocates.
  Eigen::MatrixXd covariance() const { return filter_.covariance(); }
  /// dT/dθ, N x p. Allocates.
  Eigen::MatrixXd sensitivities_K() const { return sensitivities_.in_kelvin(); }
  /// Time since reset(), to the last sample.
  double age_s() const { return times_.seen_s - times_.reset_s; }
  long updates() const { return updates_; }
  /// Periods whose sensitivities could not be carried on; 0 in good health.
  long failures() const { return failures_; }

  /// Sizes `state` on the first call, then cycle-safe.
  void save(EstimatorState& state) const;
  /// After reset() with the nodes of the same instant. False, and nothing changed, where the sizes are not those of
  /// this network and these options or an entry is not finite.
  bool restore(const EstimatorState& state);

 private:
  friend class SecondPass;
  /// A length that waits for the next update.
  struct DisplacementChannel {
    std::vector<Eigen::VectorXd> rows;  ///< on x, one per deformation
    SensorRecord record;
    int index = 0;
    double value_m = 0.0, variance_m2 = 1.0;
    bool pending = false;
  };

  /// Of the last reset, update and sample; of the next update.
  struct Times {
    double reset_s = 0.0, fused_s = 0.0, seen_s = 0.0, due_s = 0.0;
    double fresh_until_s = 0.0;
  };
  /// What is more open than the priors say.
  struct Openness {
    double start_memory_s = 0.0;   ///< of a start after a pause: > 0, its parameter forgets
    double widened_s = 0.0;        ///< when the start was opened
    Eigen::VectorXd start_missed;  ///< 1σ of what the effect of each start parameter may miss, when it was opened
    double disturbance = 1.0;      ///< of the unexplained heats, times their prior's deviation
    double environment = 1.0;      ///< of what environments read wrong, times their prior's deviation
  };

  /// What is known at one instant, from which a second pass begins.
  struct Instant {
    SquareRootFilter filter;
    Eigen::MatrixXd sensitivities;
    std::vector<SensorChannel> channels;
    Consistency consistency;
    Eigen::VectorXd nodes_K, flow_kg_per_s;
    Times times;
    Openness open;
    bool knows_calibration = true;
  };
  /// Sizes `to` on the first call, then cycle-safe.
  void note_instant(Instant& to) const;
  /// Of a second pass: from this instant on, as if these unknowns had been known from the start. The model and all rows
  /// are theirs until release(), while the filter's mean and P go on from those of the instant.
  void hold(const Instant& from, const Eigen::VectorXd& unknowns, const rom::OperatingState& operating);
  /// Ends it: the unknowns are those of the filter, and the state with them.
  void release();
  /// Goes over to what a second pass has come to at the same instant.
  void take_over(const EstimatorCorrection& pass, const rom::OperatingState& operating);
  /// What was recorded for a second pass is of another estimate.
  void begin_another_record();
  /// Unknowns that the model and all rows belong to.
  const Eigen::VectorXd& linearised_at() const { return is_held_ ? held_at_ : filter_.mean(); }

  Eigen::Index offset_at(Eigen::Index sensor) const { return parameters_.count() + sensor; }
  Eigen::Index lag_at(Eigen::Index sensor) const;
  bool has_lags() const { return options_.lag_deviation_s > 0.0; }
  /// An unknown that is of the machine or of a sensor's mounting, and stays when a day is over.
  bool stays(Eigen::Index unknown) const;
  void look_where_sensors_are();
  void forget();
  void begin_with_what_is_known();
  void publish_factors(const rom::OperatingState& operating);
  void open_period(double time_s, const rom::OperatingState& operating);
  void close_period(double time_s);
  void pass_time(double elapsed_s);
  void note_curvature();
  /// Σ (noise² + floor²) / Σ (noise² + least floor²) over the sensors that were taken in within the floor's memory.
  double chi_square_of_readings() const;
  void publish_deviations();
  double curvature_variance(const Eigen::Ref<const Eigen::VectorXd>& sensitivity) const;

  /// What a straight line in a sensor's lag leaves out while the lag is open.
  double lag_curvature_variance(Eigen::Index sensor) const;

  /// Row, innovation and noise of every sensor that has readings.
  void measure(double time_s);
  void measure_displacement();
  /// The same with the filter's mean as it is now.
  void fuse(SensorRecord& to, const Eigen::Ref<const Eigen::VectorXd>& row, double innovation, double noise);
  void fuse_sensors(double time_s);
  void fuse_displacement();
  void fuse_tares();
  /// Whether the readings contradict the estimate. Notes what the innovations say.
  bool contradicted(double time_s);
  /// Deviations of all parameters back to those of the prior, around the present means; the start is now, as open as
  /// the largest innovation says; heats that no source explains become wider, `by_health` (note_contradiction) less.
  void loosen(double widest_K, bool by_health);
  /// Unknowns further from their prior than it makes likely, in an estimate that its readings contradict, are no
  /// knowledge: they go back to it.
  void forget_the_implausible(bool as_unknown);
  /// Prior to which an unknown is loosened.
  struct Opened {
    double mean = 0.0;
    double deviation = 0.0;  ///< 1σ
  };
  /// That of the unknown's own prior; `as_unknown` that of a machine that nobody has tested.
  Opened opened(Eigen::Index i, bool as_unknown) const;
  void open_start(double widest_K, double shapes_share, double groups_share);
  void look_at_the_start();
  /// A flow that was told to have changed leaves the films of its circuit as open as their prior.
  void widen_films(const rom::OperatingState& operating);
  /// Unexplained heats become wider, at least `first` of their prior's deviations.
  void widen_disturbances(double first);
  void widen_disturbances_to(double deviations);
  /// Heats that no source explains become as wide as where readings contradict, if they are not yet (note_change).
  void heed_change();
  /// What environments read wrong may be as large as widest_K from now on, and fades again within hours.
  void widen_environments(double widest_K);
  /// Of a parameter's prior deviation, how many it may be at the moment.
  static double width_of(const Parameter& parameter, const Widths& widths);
  /// Heats that no source explains become wide where the length that waits is further off than its variance allows
  /// for; not where the gate rejects it even so, unless the one before was rejected to the same side.
  void open_heats_by_length();
  bool update(double time_s);
  /// z from the filter, within its limits, and the state with it. Whether θ moved.
  bool follow_filter();

  const rom::Network* network_;
  EstimatorOptions options_;
  std::shared_ptr<const rom::NetworkOperator> coordinates_;
  ParameterModel parameters_;
  Sensitivities sensitivities_;
  DeviationOfOutputs outputs_;
  HeldPeriod period_;
  Consistency consistency_;
  ReducedChiSquare chi_square_;
  SquareRootFilter filter_, prior_;
  SquareRootFilter before_length_;  ///< before a length opened the unexplained heats
  CalibrationRecall recall_;
  bool knows_calibration_ = true;  ///< false: readings have contradicted it
  Eigen::VectorXd known_mean_;     ///< that the next start begins with instead of the prior; empty: with the prior
  Eigen::MatrixXd known_root_;
  EstimatorUpdate made_;
  std::vector<SensorChannel> channels_;
  std::vector<SensorRecord> records_;
  DisplacementChannel displacement_;
  Eigen::VectorXd prior_mean_, neutral_mean_, keep_, growth_, row_, gain_;
  Eigen::VectorXd theta_, theta_step_, place_;
  Eigen::VectorXd curvature_;  ///< √(κ/2) P_ii of the ln factors, of the start what its effect may miss, else 0
  Eigen::VectorXd tare_deviation_K_;  ///< of the sensors that wait for fuse_tares(); 0: none
  Eigen::VectorXd bias_K_, rises_K_, nodes_K_, corrected_K_;
  rom::CorrectionFactors factors_;
  Eigen::VectorXd known_flow_kg_per_s_;  ///< that the films were learnt at
  /// So long after a start the sensitivities are carried on in every cycle: all that is not known comes into play then.
  static constexpr double fresh_s = 30.0;
  Times times_;
  Openness open_;
  double disturbance_idle_ = 1.0;  ///< open_.disturbance while nothing speaks for any
  bool contradicted_ = false;      ///< told so
  bool changed_ = false;           ///< the spindle, told so
  bool started_ = false, standing_by_ = false, start_unseen_ = false;
  bool is_held_ = false, held_in_vain_ = false;  ///< a second pass; whose readings contradict it
  Eigen::VectorXd held_at_;                      ///< the unknowns that it is linearised about
  std::unique_ptr<SecondPass> second_pass_;      ///< null: not asked for
  long updates_ = 0, failures_ = 0, loosened_ = 0, relinearised_ = 0;
  double loosened_s_ = SensorChannel::never_s;  ///< when it was loosened last
};

}  // namespace spindle_twin::correction

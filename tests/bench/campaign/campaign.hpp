#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "fem_offline/model/affine_model.hpp"
#include "rom/network.hpp"

/// Virtual spindles against their twins: the truth is the FE model on another mesh, with laws, joints and inlets that
/// the twin is not told.
namespace spindle_twin::bench {

constexpr double run_s = 7200.0;
constexpr double sample_s = 10.0;
constexpr double judged_from_s = 900.0;
constexpr double touch_off_s = 1800.0;
constexpr double touch_off_m = 1e-6;

enum class HeatErrors { independent, common };  // "A", "B"

/// Speed and load from the block before it on.
struct DriveBlock {
  double until_s = 0.0;
  double speed_rpm = 0.0;
  double load = 0.0;
};

/// What a run is like beside its hidden factors.
struct Conditions {
  double run_s = bench::run_s;
  double sample_s = bench::sample_s;   ///< between readings; the estimator's period as well
  double lag_s = 0.0;                  ///< of the sensors, first order; the twin is told
  bool standstill = false;             ///< the spindle stands through the third quarter of the run
  double speed_exponent = 0.0;         ///< 1σ of what the heats' speed exponents are wrong by
  double expansion = 0.0;              ///< 1σ of ln of how much more the machine expands than the twin believes
  std::vector<DriveBlock> drive = {};  ///< empty: drawn
  Eigen::VectorXd theta = {};          ///< hidden parameters of a machine that is known already; empty: drawn
};

/// What one virtual spindle is and what its sensors say, sample by sample.
struct Truth {
  std::uint64_t seed = 0;
  HeatErrors heats = HeatErrors::independent;
  Conditions conditions;
  Eigen::VectorXd theta;  ///< hidden parameters in the order of the twin's ParameterModel at the start of the run
  std::vector<rom::OperatingState> read;  ///< what the twin is told
  Eigen::MatrixXd key_points_K;           ///< samples x key points
  Eigen::MatrixXd measured_K;
  Eigen::VectorXd nose_m;
  Eigen::VectorXd touch_off_m;  ///< reading of the nose at every sample; used every touch_off_s
  Eigen::VectorXd rotor_K;      ///< maximum
};

/// ln of the factor by which a contact has drifted at time_s.
double drift(const Conditions& conditions, double time_s);

Truth make_truth(const fem_offline::AffineModel& model, const correction::ParameterModel& parameters,
                 std::uint64_t seed, HeatErrors heats, const Conditions& conditions = {});

/// Priors as the truth is drawn from them.
correction::EstimatorPriors priors_of(HeatErrors heats);

/// How well one twin followed one truth, from judged_from_s on.
struct Score {
  double error_um = 0.0;      ///< rms
  double deviation_um = 0.0;  ///< rms of the published 1σ; 0 where none is published
  double inside = 0.0;        ///< share of the samples whose truth lies within ±2σ
  double key_points_K = 0.0;  ///< rms over the sensors in use
  double rotor_K = 0.0;       ///< rms
  long rejected = 0;
};

Score run_open_loop(const rom::Network& network, const Truth& truth);
/// The published law, one heat factor every 80 s and the joint law, behind the guards. `correct_state`: with our own
/// addition to it, that the rise is corrected together with the heat.
Score run_paper(const rom::Network& network, const Truth& truth, int sensors, bool correct_state);
Score run_estimator(const rom::Network& network, const Truth& truth, int sensors, bool touch_off,
                    const correction::EstimatorOptions& options);
/// The estimator without a reading: its priors alone, with their σ.
Score run_blind(const rom::Network& network, const Truth& truth, const correction::EstimatorOptions& options);
/// rms of the nose's σ that the same filter would have if it had the true parameters and offsets from the start: the
/// linearised Bayesian posterior of these sensors. [um]
double bound_um(const rom::Network& network, const Truth& truth, int sensors, bool touch_off,
                const correction::EstimatorOptions& options);

}  // namespace spindle_twin::bench

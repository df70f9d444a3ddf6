#include <algorithm>
#include <cmath>

#include "correction/estimator/estimator_correction.hpp"

// What opens the estimate again: readings that contradict it, a start that nobody knows, a flow that was told to
// change.
namespace spindle_twin::correction {
namespace {

constexpr double least_start_K = 0.2;       // σ of the uniform start
constexpr double start_groups_share = 0.5;  // of that, per thermal group
constexpr double implausible = 2.0;         // deviations of its prior, in an estimate that readings contradict
// What contradicts a loosened estimate again within this time is another machine than the one that was calibrated: the
// first loosening gives a calibrated estimate back all of its own deviations, and an hour is two to four of the time
// constants by which a spindle's heats show.
constexpr double again_within_s = 3600.0;
constexpr double untared_K = 0.1;  // σ of a class A PT100 without tare, its tolerance taken for 2σ (IEC 60751)
// Unexplained heats, in deviations of their prior: opened to the first, or to so many times what they were, at most to
// the widest.
constexpr double disturbance_step = 3.0;
constexpr double disturbance_first = 2.0;
constexpr double disturbance_widest = 30.0;
// Where health asks for it, it may be a sensor that drifts: as wide heats would follow it wherever it goes. Less than
// what heats_are_open() counts, so that UnexplainedHeat looks for one all the same.
constexpr double disturbance_by_health = 0.4;
// What environments read wrong, of the largest innovation: a sensor shows a part of it. At most so many deviations.
constexpr double environment_share = 2.0;
constexpr double environment_widest = 50.0;

constexpr double new_flow_share = 0.1;  // a film learnt at one flow is another at a flow that differs by more

}  // namespace

void EstimatorCorrection::widen_disturbances(double first) {
  widen_disturbances_to(std::clamp(disturbance_step * open_.disturbance, first, disturbance_widest));
}

void EstimatorCorrection::widen_disturbances_to(double deviations) {
  if (!parameters_.has_disturbances()) return;
  open_.disturbance = deviations;
  for (std::size_t g = 0; g < parameters_.groups().size(); ++g) {
    const Eigen::Index slot = parameters_.disturbance(static_cast<Eigen::Index>(g));
    const double wanted = open_.disturbance * parameters_.list()[static_cast<std::size_t>(slot)].deviation;
    const double missing = wanted * wanted - std::pow(keep_[slot] * filter_.deviation(slot), 2.0);
    growth_[slot] = std::max(growth_[slot], missing);
  }
}

void EstimatorCorrection::heed_change() {
  if (!changed_) return;
  changed_ = false;
  keep_.setOnes();
  growth_.setZero();
  widen_disturbances_to(std::max(open_.disturbance, disturbance_first));
  filter_.widen(keep_, growth_);
  begin_another_record();
}

void EstimatorCorrection::widen_environments(double widest_K) {
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    if (parameter.kind != ParameterKind::environment || !(parameter.deviation > 0.0)) continue;
    open_.environment = std::max(open_.environment, std::min(widest_K / parameter.deviation, environment_widest));
    const double wanted_K = open_.environment * parameter.deviation;
    growth_[i] = std::max(growth_[i], wanted_K * wanted_K - std::pow(keep_[i] * filter_.deviation(i), 2.0));
  }
}

void EstimatorCorrection::open_start(double widest_K, double shapes_share, double groups_share) {
  const Eigen::Index first = parameters_.start();
  if (first < 0) return;
  for (Eigen::Index i = first; i < parameters_.count(); ++i) {
    const double share = i == first ? 1.0 : (parameters_.is_start_of_group(i) ? groups_share : shapes_share);
    const double least_K = parameters_.list()[static_cast<std::size_t>(i)].deviation;
    keep_[i] = 0.0;
    const double deviation_K = std::max(share * widest_K, least_K);
    growth_[i] = deviation_K * deviation_K;
    open_.start_missed[i - first] = start_missed_share * deviation_K;
  }
  open_.widened_s = times_.seen_s;
}

EstimatorCorrection::Opened EstimatorCorrection::opened(Eigen::Index i, bool as_unknown) const {
  if (!as_unknown || i >= parameters_.count()) return {prior_mean_[i], filter_.scale()[i]};
  const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
  return {parameter.uncalibrated_mean, parameter.uncalibrated_deviation};
}

void EstimatorCorrection::forget_the_implausible(bool as_unknown) {
  row_ = filter_.mean();
  for (Eigen::Index i = 0; i < filter_.size(); ++i) {
    const bool is_parameter = i < parameters_.count();
    const double width = is_parameter ? width_of(parameters_.list()[static_cast<std::size_t>(i)], widths()) : 1.0;
    const Opened open = opened(i, as_unknown);
    const double deviation = std::max(width, 1.0) * open.deviation;
    if (!(std::abs(row_[i] - open.mean) > implausible * deviation)) continue;
    row_[i] = open.mean;
    keep_[i] = 0.0;
    growth_[i] = deviation * deviation;
    if (!is_parameter) continue;
    sensitivities_.clear(i);
    for (SensorChannel& channel : channels_) channel.set_sensitivity_at(i, 0.0);
  }
  filter_.set_mean(row_);
}

void EstimatorCorrection::loosen(double widest_K, bool by_health) {
  ++loosened_;
  begin_another_record();
  const bool as_unknown = times_.seen_s - loosened_s_ < again_within_s;
  loosened_s_ = times_.seen_s;
  if (as_unknown) knows_calibration_ = false;
  const double open_K = std::max(widest_K, least_start_K);
  keep_.setOnes();
  growth_.setZero();
  for (Eigen::Index i = 0; i < filter_.size(); ++i) {
    const bool shut = by_health && i < parameters_.count() &&
                      parameters_.list()[static_cast<std::size_t>(i)].kind == ParameterKind::disturbance;
    if (shut) continue;
    const double deviation = filter_.deviation(i);
    if (deviation > 0.0) keep_[i] = std::max(1.0, opened(i, as_unknown).deviation / deviation);
  }
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    const double wanted_K = std::min(0.5 * open_K, untared_K),
                 b = keep_[offset_at(s)] * filter_.deviation(offset_at(s));
    growth_[offset_at(s)] = std::max(0.0, wanted_K * wanted_K - b * b);
  }
  widen_disturbances(by_health ? disturbance_by_health : disturbance_first);
  widen_environments(environment_share * open_K);
  forget_the_implausible(as_unknown);
  open_start(open_K, start_groups_share, start_groups_share);
  filter_.widen(keep_, growth_);
  open_.start_memory_s = 0.0;
  sensitivities_.restart(parameters_);
  // What the start has done until now is in the state.
  row_ = filter_.mean();
  row_.segment(parameters_.count() - parameters_.starts(), parameters_.starts()).setZero();
  filter_.set_mean(row_);
  made_.unknowns = row_;
  for (SensorChannel& channel : channels_) {
    sensitivities_.of_row(channel.internal(), place_);
    if (parameters_.start() >= 0) channel.set_sensitivity_from(parameters_.start(), place_);
  }
  note_curvature();
}

void EstimatorCorrection::widen_films(const rom::OperatingState& operating) {
  bool changed = false;
  keep_.setOnes();
  growth_.setZero();
  for (Eigen::Index c = 0; c < known_flow_kg_per_s_.size(); ++c) {
    double& known = known_flow_kg_per_s_[c];
    const double now = operating.flow_kg_per_s[c];
    if (!(std::abs(now - known) > new_flow_share * std::max(std::abs(now), std::abs(known)))) continue;
    known = now;
    changed = true;
    for (const int segment : network_->boundaries.circuits[static_cast<std::size_t>(c)].segments) {
      const int slot = parameters_.conductance(segment);
      // A calibration was of the film at the flow of its test.
      if (slot >= 0) keep_[slot] = std::max(1.0, opened(slot, true).deviation / filter_.deviation(slot));
    }
  }
  if (!changed) return;
  filter_.widen(keep_, growth_);
  note_curvature();
}

void EstimatorCorrection::look_at_the_start() {
  double widest_K = 0.0, expected_K = 0.0;
  bool seen = false;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    if (channels_[s].samples() == 0) continue;
    seen = true;
    const EstimatorSensor& sensor = options_.sensors[s];
    widest_K = std::max(widest_K, std::abs(channels_[s].mean_residual_K()));
    expected_K = std::max(expected_K, std::hypot(sensor.noise_K, sensor.offset_deviation_K));
  }
  if (!seen) return;
  start_unseen_ = false;
  if (parameters_.start() < 0 || widest_K <= start_isothermal * expected_K) return;
  keep_.setOnes();
  growth_.setZero();
  open_start(widest_K, open_rises_share, open_groups_share);
  filter_.widen(keep_, growth_);
  note_curvature();
  publish_deviations();
}

}  // namespace spindle_twin::correction

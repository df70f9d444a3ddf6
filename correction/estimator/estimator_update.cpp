#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
/// Largest step of an ln factor by one reading: as far as a straight line stands for e^θ.
constexpr double straight = 0.3;
constexpr double by_chance = 3.0;  ///< deviations of what it leaves out that the rest of a reading may hide
constexpr double longest_lag_s = 120.0;
constexpr double lag_missed = 0.3;  // of what an open lag does, the share that a straight line in it leaves out

// How the estimate is loosened.
constexpr double least_start_K = 0.2;       // σ of the uniform start
constexpr double start_groups_share = 0.5;  // of that, per thermal group
constexpr double implausible = 2.0;         // deviations of its prior, in an estimate that readings contradict
// What contradicts a loosened estimate again within this time is another machine than the one that was calibrated: the
// first loosening gives a calibrated estimate back all of its own deviations, and an hour is two to four of the time
// constants by which a spindle's heats show.
constexpr double again_within_s = 3600.0;
constexpr double untared_K = 0.1;  // σ of a class A PT100 without tare, its tolerance taken for 2σ (IEC 60751)
// Unexplained heats, in deviations of their prior: opened to the first, or to so many times what they were, at most to
// the widest. A length tells of the nose what no sensor does, so it opens them further.
constexpr double disturbance_step = 3.0;
constexpr double disturbance_first = 2.0;
constexpr double disturbance_by_length = 8.0;
constexpr double disturbance_widest = 30.0;
// What environments read wrong, of the largest innovation: a sensor shows a part of it. At most so many deviations.
constexpr double environment_share = 2.0;
constexpr double environment_widest = 50.0;
constexpr double displacement_nis = 2.0;  // squared innovation of a length over its variance, from which it opens them

constexpr double new_flow_share = 0.1;  // a film learnt at one flow is another at a flow that differs by more

// A start of which nothing is known.
constexpr double isothermal = 3.0;  // deviations of one reading within which the sensors stand at one temperature
// Of the largest reading off the mean: σ of the steady rises, whose hottest place no sensor sees, and of each group;
// and what a group's own temperature differences add to either. Larger ones change nothing (warm_restart of
// tests/bench/reality_campaign), smaller ones leave the truth outside.
constexpr double open_shapes_share = 2.0;
constexpr double open_groups_share = 1.0;
constexpr double shape_missed = 0.3;

}  // namespace

double EstimatorCorrection::curvature_variance(const Eigen::Ref<const Eigen::VectorXd>& sensitivity) const {
  return sensitivity.cwiseProduct(curvature_).squaredNorm();
}

double EstimatorCorrection::lag_curvature_variance(Eigen::Index sensor) const {
  if (!has_lags()) return 0.0;
  const double slope_K_per_s = channels_[static_cast<std::size_t>(sensor)].mean_lag_slope();
  const double missed_K = lag_missed * slope_K_per_s * filter_.deviation(lag_at(sensor));
  return missed_K * missed_K;
}

void EstimatorCorrection::measure(double time_s) {
  const Eigen::Index p = parameters_.count();
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    const SensorChannel& channel = channels_[static_cast<std::size_t>(s)];
    const EstimatorSensor& sensor = options_.sensors[static_cast<std::size_t>(s)];
    auto row = made_.rows.col(s);
    row.setZero();
    row.head(p) = channel.sensitivity();
    row[offset_at(s)] = 1.0;
    if (has_lags()) row[lag_at(s)] = channel.mean_lag_slope();
    made_.innovation_K[s] = no_value;
    if (channel.samples() == 0) continue;
    made_.innovation_K[s] = channel.mean_residual_K() - filter_.mean()[offset_at(s)];
    const double interval_s = std::max(time_s - channel.fused_s, options_.period_s);
    const double floor_K = consistency_.floor_K(s);
    // A straight line leaves out no more than what is left of the readings, but by chance.
    const double seen_K2 = std::max(consistency_.square_K2(s), made_.innovation_K[s] * made_.innovation_K[s]);
    const double left_out_K2 = std::min(curvature_variance(channel.sensitivity()) + lag_curvature_variance(s),
                                        by_chance * by_chance * seen_K2);
    const double one_reading_K2 = sensor.noise_K * sensor.noise_K / channel.samples() + floor_K * floor_K + left_out_K2;
    made_.noise_K2[s] = one_reading_K2 * std::max(1.0, options_.correlation_s / interval_s);
  }
}

void EstimatorCorrection::measure_displacement() {
  made_.displacement_m = no_value;
  if (!displacement_.pending) return;
  const auto index = static_cast<std::size_t>(displacement_.index);
  const Eigen::VectorXd& row = network_->deformations[index].row_m_per_K;
  sensitivities_.of_row(displacement_.rows[index], place_);
  double length_m = row.dot(nodes_K_) - row.sum() * network_->boundaries.reference_temperature_K;
  parameters_.expand(theta_, length_m, place_);
  made_.displacement_row << place_, Eigen::VectorXd::Zero(made_.displacement_row.size() - place_.size());
  made_.displacement_m = displacement_.value_m - length_m;
  made_.displacement_variance_m2 = displacement_.variance_m2 + curvature_variance(place_);
}

bool EstimatorCorrection::contradicted(double time_s) {
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    const SensorChannel& channel = channels_[static_cast<std::size_t>(s)];
    if (channel.samples() == 0) continue;
    row_ = made_.rows.col(s);
    const double known_K2 = filter_.variance_of(row_);
    const double variance_K2 = known_K2 + made_.noise_K2[s];
    const double innovation_K = made_.innovation_K[s];
    const double noise_K = options_.sensors[static_cast<std::size_t>(s)].noise_K;
    const double explained_K2 =
        known_K2 + noise_K * noise_K / channel.samples() + curvature_variance(channel.sensitivity());
    const bool rejected = !(innovation_K * innovation_K <= options_.gate * options_.gate * variance_K2);
    consistency_.note(s, innovation_K, variance_K2, explained_K2, rejected,
                      std::min(made_.elapsed_s, time_s - channel.fused_s));
  }
  return consistency_.conclude(made_.elapsed_s);
}

void EstimatorCorrection::fuse(SensorRecord& record, const Eigen::Ref<const Eigen::VectorXd>& row, double innovation,
                               double noise) {
  row_ = row;
  const double known = filter_.variance_of(row_, gain_);
  // The larger of the step that one reading may make in an ln factor sets how much it counts.
  double largest = 0.0;
  for (Eigen::Index i = 0; i < curvature_.size(); ++i) {
    if (curvature_[i] > 0.0 && !parameters_.is_start(i)) largest = std::max(largest, std::abs(gain_[i]));
  }
  record.innovation_K = innovation;
  record.variance_K2 = known + noise;
  record.test_ratio = innovation * innovation / (options_.gate * options_.gate * record.variance_K2);
  record.rejected = !(record.test_ratio <= 1.0);
  const double bounded = std::max(noise, std::abs(innovation) * largest / straight - known);
  record.fused = !record.rejected && filter_.update(row_, innovation, bounded);
  record.rejected_in_a_row = record.rejected ? record.rejected_in_a_row + 1 : 0;
}

void EstimatorCorrection::fuse_sensors(double time_s) {
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    SensorChannel& channel = channels_[static_cast<std::size_t>(s)];
    SensorRecord& record = records_[static_cast<std::size_t>(s)];
    record.rejected = record.fused = false;
    record.observation_K = channel.mean_reading_K();
    if (channel.samples() == 0) continue;
    fuse(record, made_.rows.col(s), made_.innovation_at(s, filter_.mean()), made_.noise_K2[s]);
    if (record.fused) channel.fused_s = time_s;
  }
}

void EstimatorCorrection::fuse_displacement() {
  if (!displacement_.pending) return;
  displacement_.pending = false;
  displacement_.record.observation_K = displacement_.value_m;
  fuse(displacement_.record, made_.displacement_row, made_.displacement_at(filter_.mean()),
       made_.displacement_variance_m2);
}

void EstimatorCorrection::fuse_tares() {
  for (Eigen::Index s = 0; s < tare_deviation_K_.size(); ++s) {
    if (!(tare_deviation_K_[s] > 0.0)) continue;
    const Eigen::Index b = offset_at(s);
    row_.setZero();
    row_[b] = 1.0;
    filter_.update(row_, -filter_.mean()[b], tare_deviation_K_[s] * tare_deviation_K_[s]);
    tare_deviation_K_[s] = 0.0;
  }
}

void EstimatorCorrection::widen_disturbances(double first) {
  if (!parameters_.has_disturbances()) return;
  disturbance_width_ = std::clamp(disturbance_step * disturbance_width_, first, disturbance_widest);
  for (std::size_t g = 0; g < parameters_.groups().size(); ++g) {
    const Eigen::Index slot = parameters_.disturbance(static_cast<Eigen::Index>(g));
    const double wanted = disturbance_width_ * parameters_.list()[static_cast<std::size_t>(slot)].deviation;
    const double missing = wanted * wanted - std::pow(keep_[slot] * filter_.deviation(slot), 2.0);
    growth_[slot] = std::max(growth_[slot], missing);
  }
}

void EstimatorCorrection::widen_environments(double widest_K) {
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    if (parameter.kind != ParameterKind::environment || !(parameter.deviation > 0.0)) continue;
    environment_width_ = std::max(environment_width_, std::min(widest_K / parameter.deviation, environment_widest));
    const double wanted_K = environment_width_ * parameter.deviation;
    growth_[i] = std::max(growth_[i], wanted_K * wanted_K - std::pow(keep_[i] * filter_.deviation(i), 2.0));
  }
}

void EstimatorCorrection::open_start(double widest_K, double shapes_share, double groups_share) {
  const Eigen::Index first = parameters_.start();
  if (first < 0) return;
  const auto groups = static_cast<Eigen::Index>(parameters_.groups().size());
  for (Eigen::Index i = first; i < parameters_.count(); ++i) {
    const bool group = i >= parameters_.count() - groups;
    const double share = i == first ? 1.0 : (group ? groups_share : shapes_share);
    const double least_K = parameters_.list()[static_cast<std::size_t>(i)].deviation;
    keep_[i] = 0.0;
    const double deviation_K = std::max(share * widest_K, least_K);
    growth_[i] = deviation_K * deviation_K;
    start_missed_[i - first] = shape_missed * deviation_K;
  }
  widened_s_ = seen_s_;
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
    const double width = is_parameter ? width_of(parameters_.list()[static_cast<std::size_t>(i)]) : 1.0;
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

void EstimatorCorrection::loosen(double widest_K) {
  ++loosened_;
  const bool as_unknown = seen_s_ - loosened_s_ < again_within_s;
  loosened_s_ = seen_s_;
  if (as_unknown) knows_calibration_ = false;
  const double open_K = std::max(widest_K, least_start_K);
  keep_.setOnes();
  growth_.setZero();
  for (Eigen::Index i = 0; i < filter_.size(); ++i) {
    const double deviation = filter_.deviation(i);
    if (deviation > 0.0) keep_[i] = std::max(1.0, opened(i, as_unknown).deviation / deviation);
  }
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    const double wanted_K = std::min(0.5 * open_K, untared_K),
                 b = keep_[offset_at(s)] * filter_.deviation(offset_at(s));
    growth_[offset_at(s)] = std::max(0.0, wanted_K * wanted_K - b * b);
  }
  widen_disturbances(disturbance_first);
  widen_environments(environment_share * open_K);
  forget_the_implausible(as_unknown);
  open_start(open_K, start_groups_share, start_groups_share);
  filter_.widen(keep_, growth_);
  start_memory_s_ = 0.0;
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
  if (parameters_.start() < 0 || widest_K <= isothermal * expected_K) return;
  keep_.setOnes();
  growth_.setZero();
  open_start(widest_K, open_shapes_share, open_groups_share);
  filter_.widen(keep_, growth_);
  note_curvature();
  outputs_.evaluate(sensitivities_, filter_, curvature_, nodes_K_);
}

bool EstimatorCorrection::displacement_contradicts() {
  if (!displacement_.pending) return false;
  row_ = made_.displacement_row;
  const double variance_m2 = filter_.variance_of(row_) + made_.displacement_variance_m2;
  return made_.displacement_m * made_.displacement_m > displacement_nis * variance_m2;
}

bool EstimatorCorrection::update(double time_s) {
  made_.elapsed_s = time_s - fused_s_;
  pass_time(made_.elapsed_s);
  if (knows_calibration_) recall_.take_in(made_.elapsed_s, filter_);
  fused_s_ = time_s;
  made_.unknowns = filter_.mean();
  measure(time_s);
  if (contradicted_) consistency_.contradict();
  const bool found = contradicted(time_s);
  if (found || contradicted_) {
    contradicted_ = false;
    loosen(consistency_.largest_innovation_K());
    measure(time_s);
  }
  measure_displacement();
  if (displacement_contradicts()) {
    keep_.setOnes();
    growth_.setZero();
    widen_disturbances(disturbance_by_length);
    filter_.widen(keep_, growth_);
  }
  fuse_sensors(time_s);
  fuse_tares();
  fuse_displacement();
  const bool moved = follow_filter();
  for (SensorChannel& channel : channels_) channel.clear();
  ++updates_;
  return moved;
}

void EstimatorCorrection::bound(Eigen::VectorXd& unknowns) const {
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    unknowns[i] = std::clamp(unknowns[i], parameter.minimum, parameter.maximum);
  }
  for (Eigen::Index s = 0; has_lags() && s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    unknowns[lag_at(s)] = std::clamp(unknowns[lag_at(s)], 0.0, longest_lag_s);
  }
}

bool EstimatorCorrection::follow_filter() {
  const Eigen::Index p = parameters_.count();
  row_ = filter_.mean();
  bound(row_);
  filter_.set_mean(row_);
  theta_ = row_.head(p);
  theta_step_ = theta_ - made_.unknowns.head(p);
  corrected_K_ = nodes_K_;
  const bool moved = theta_step_.squaredNorm() > 0.0;
  if (moved) sensitivities_.correct(theta_step_, corrected_K_);
  nodes_K_ = corrected_K_;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    const auto index = static_cast<Eigen::Index>(s);
    sensitivities_.of_row(channels_[s].internal(), place_);
    const double lag_step_s = has_lags() ? row_[lag_at(index)] - made_.unknowns[lag_at(index)] : 0.0;
    channels_[s].correct(place_, theta_step_, lag_step_s);
    records_[s].offset_K = row_[offset_at(index)];
    records_[s].offset_deviation_K = filter_.deviation(offset_at(index));
  }
  note_curvature();
  outputs_.evaluate(sensitivities_, filter_, curvature_, nodes_K_);
  return moved;
}

void EstimatorCorrection::widen_offset(Eigen::Index sensor, double deviation_K) {
  keep_.setOnes();
  growth_.setZero();
  growth_[offset_at(sensor)] = deviation_K * deviation_K;
  filter_.pass_time(prior_mean_, keep_, growth_);
}

void EstimatorCorrection::note_tare(Eigen::Index sensor, double shift_K, double deviation_K) {
  row_ = filter_.mean();
  row_[offset_at(sensor)] -= shift_K;
  filter_.set_mean(row_);
  channels_[static_cast<std::size_t>(sensor)].clear();
  records_[static_cast<std::size_t>(sensor)].offset_K = row_[offset_at(sensor)];
  tare_deviation_K_[sensor] = deviation_K;
}

void EstimatorCorrection::note_displacement(int index, double value_m, double deviation_m) {
  if (index < 0 || index >= static_cast<int>(displacement_.rows.size())) return;
  if (!std::isfinite(value_m) || !(deviation_m > 0.0)) return;
  displacement_.index = index;
  displacement_.value_m = value_m;
  displacement_.variance_m2 = deviation_m * deviation_m;
  displacement_.pending = true;
}

}  // namespace spindle_twin::correction

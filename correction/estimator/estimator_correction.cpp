#include "correction/estimator/estimator_correction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "correction/estimator/check_options.hpp"
#include "correction/estimator/second_pass.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/units.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double due_slack_s = 1e-6;
constexpr double disturbance_width_memory_s = 7200.0;
constexpr double environment_width_memory_s = 14400.0;
constexpr double idle_width = 1e-3;
constexpr double open_width = 2.0;
constexpr double start_missed_memory_s = 600.0;
constexpr double least_floor_K = 1e-3;

ConsistencyLimits limits_of(const rom::Network& network, const EstimatorOptions& options) {
  ConsistencyLimits limits;
  limits.floor_K = std::max(network.hand_written ? std::max(options.floor_K, options.floor_by_hand_K) : options.floor_K,
                            least_floor_K);
  limits.floor_largest_K = std::max(options.floor_largest_K, limits.floor_K);
  return limits;
}

}  // namespace

std::vector<EstimatorSensor> key_point_sensors(const rom::Network& network, const EstimatorOptions& options) {
  std::vector<EstimatorSensor> sensors;
  for (const rom::KeyPoint& point : network.key_points) {
    sensors.push_back({point.name, point.row, options.noise_K, options.offset_deviation_K, options.lag_s});
  }
  return sensors;
}

EstimatorCorrection::EstimatorCorrection(const rom::Network& network, EstimatorOptions options,
                                         std::shared_ptr<const rom::NetworkOperator> shared)
    : network_(&network),
      options_(checked(network, std::move(options))),
      coordinates_(shared ? std::move(shared) : std::make_shared<const rom::NetworkOperator>(network)),
      parameters_(network, options_.priors),
      sensitivities_(network, coordinates_, parameters_),
      outputs_(network, sensitivities_, parameters_, options_.curvature > 0.0),
      period_(network, coordinates_),
      consistency_(limits_of(network, options_), static_cast<Eigen::Index>(options_.sensors.size())) {
  const Eigen::Index p = parameters_.count();
  const auto m = static_cast<Eigen::Index>(options_.sensors.size());
  const Eigen::Index n = p + m + (has_lags() ? m : 0), nodes = coordinates_->nodes();
  prior_mean_ = neutral_mean_ = Eigen::VectorXd::Zero(n);
  prior_mean_.head(p) = parameters_.mean();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  covariance.topLeftCorner(p, p) = parameters_.covariance();
  for (Eigen::Index s = 0; s < m; ++s) {
    const EstimatorSensor& sensor = options_.sensors[static_cast<std::size_t>(s)];
    covariance(offset_at(s), offset_at(s)) = sensor.offset_deviation_K * sensor.offset_deviation_K;
    if (!has_lags()) continue;
    prior_mean_[lag_at(s)] = neutral_mean_[lag_at(s)] = sensor.lag_s;
    covariance(lag_at(s), lag_at(s)) = options_.lag_deviation_s * options_.lag_deviation_s;
  }
  // Of a certified network, and of one that a test was met with, nothing is left to explain until readings contradict
  // it.
  const bool is_a_guess = network.hand_written && parameters_.calibrated() == nullptr;
  disturbance_idle_ = open_.disturbance = is_a_guess ? 1.0 : idle_width;
  filter_ = prior_ = before_length_ = SquareRootFilter(prior_mean_, covariance);
  Eigen::VectorXd width = Eigen::VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < p; ++i) {
    if (parameters_.list()[static_cast<std::size_t>(i)].kind == ParameterKind::disturbance)
      width[i] = disturbance_idle_;
  }
  prior_.widen(width, Eigen::VectorXd::Zero(n));
  recall_ = CalibrationRecall(parameters_, n);
  made_.unknowns = made_.displacement_row = Eigen::VectorXd::Zero(n);
  made_.rows = Eigen::MatrixXd::Zero(n, m);
  made_.innovation_K = made_.noise_K2 = tare_deviation_K_ = Eigen::VectorXd::Zero(m);
  keep_ = Eigen::VectorXd::Ones(n);
  growth_ = row_ = gain_ = Eigen::VectorXd::Zero(n);
  theta_ = theta_step_ = place_ = curvature_ = Eigen::VectorXd::Zero(p);
  open_.start_missed = Eigen::VectorXd::Zero(parameters_.starts());
  outputs_.set_alternatives(Eigen::MatrixXd::Zero(p, m + 1));
  factors_ = parameters_.make_factors(network);
  bias_K_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.boundaries.environments.size()));
  rises_K_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.boundaries.sources.size()));
  corrected_K_ = nodes_K_ = Eigen::VectorXd::Zero(nodes);
  known_flow_kg_per_s_ = network.boundaries.operating.flow_kg_per_s;
  look_where_sensors_are();
  held_at_ = prior_mean_;
  if (options_.second_pass > 0.0) second_pass_ = std::make_unique<SecondPass>(network, options_, coordinates_, *this);
}

void EstimatorCorrection::look_where_sensors_are() {
  Eigen::VectorXd internal = Eigen::VectorXd::Zero(coordinates_->nodes());
  for (const EstimatorSensor& sensor : options_.sensors) {
    sensitivities_.internal_row(sensor.row, internal);
    channels_.emplace_back(internal, parameters_.count());
  }
  records_.resize(channels_.size());
  for (const rom::DeformationOutput& output : network_->deformations) {
    sensitivities_.internal_row(output.row_m_per_K, internal);
    displacement_.rows.push_back(internal);
  }
}

EstimatorCorrection::~EstimatorCorrection() = default;
EstimatorCorrection::EstimatorCorrection(EstimatorCorrection&& other) noexcept = default;
EstimatorCorrection& EstimatorCorrection::operator=(EstimatorCorrection&& other) noexcept = default;

Eigen::Index EstimatorCorrection::lag_at(Eigen::Index sensor) const {
  return offset_at(sensor) + static_cast<Eigen::Index>(options_.sensors.size());
}

double EstimatorCorrection::lag_s(Eigen::Index sensor) const {
  return has_lags() ? linearised_at()[lag_at(sensor)] : options_.sensors[static_cast<std::size_t>(sensor)].lag_s;
}

ParameterEstimate EstimatorCorrection::estimate(Eigen::Index parameter) const {
  const ParameterKind kind = parameters_.list()[static_cast<std::size_t>(parameter)].kind;
  const bool shut = kind == ParameterKind::disturbance && !heats_are_open();
  return {theta_[parameter], filter_.deviation(parameter), filter_.scale()[parameter], shut};
}

void EstimatorCorrection::set_parameters(const Eigen::VectorXd& theta) {
  filter_.set_first(theta);
  theta_ = theta;
  begin_another_record();
}

void EstimatorCorrection::forget() {
  begin_another_record();
  outputs_.clear_alternatives();
  filter_.set_mean(prior_mean_);
  filter_.set_root(prior_.root());
  theta_ = prior_mean_.head(parameters_.count());
  for (std::size_t s = 0; s < records_.size(); ++s) {
    records_[s] = {};
    records_[s].offset_deviation_K = options_.sensors[s].offset_deviation_K;
  }
  consistency_.restart();
  chi_square_.restart();
  contradicted_ = false;
  knows_calibration_ = true;
  open_.disturbance = disturbance_idle_;
  open_.environment = 1.0;
  loosened_s_ = SensorChannel::never_s;
  note_curvature();
  displacement_.pending = false;
}

void EstimatorCorrection::reset(double time_s, const Eigen::VectorXd& nodes, const rom::OperatingState& operating) {
  open_.start_memory_s = 0.0;
  open_.start_missed.setZero();
  forget();
  begin_with_what_is_known();
  sensitivities_.start(parameters_);
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    channels_[s].start(options_.sensors[s].row.dot(nodes));
    sensitivities_.of_row(channels_[s].internal(), place_);
    channels_[s].set_sensitivity(place_);
  }
  started_ = start_unseen_ = true;
  period_.drop();
  times_.reset_s = times_.fused_s = times_.seen_s = time_s;
  times_.due_s = time_s + options_.period_s;
  times_.fresh_until_s = time_s + fresh_s;
  nodes_K_ = corrected_K_ = nodes;
  known_flow_kg_per_s_ = operating.flow_kg_per_s;
  publish_factors(operating);
  publish_deviations();
}

void EstimatorCorrection::publish_factors(const rom::OperatingState& operating) {
  sensitivities_.source_rises(nodes_K_, rises_K_);
  parameters_.apply(theta_, operating.speed_rpm, rises_K_, factors_, bias_K_);
}

void EstimatorCorrection::open_period(double time_s, const rom::OperatingState& operating) {
  period_.open(time_s, nodes_K_, operating, factors_, bias_K_);
  for (SensorChannel& channel : channels_) {
    sensitivities_.of_row(channel.internal(), place_);
    channel.begin_period(place_);
  }
}

void EstimatorCorrection::close_period(double time_s) {
  if (!period_.is_open()) return;
  const double period_s = period_.close(time_s, nodes_K_, theta_, parameters_, sensitivities_);
  if (period_s < 0.0) ++failures_;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    sensitivities_.of_row(channels_[s].internal(), place_);
    channels_[s].end_period(place_, std::abs(period_s), lag_s(static_cast<Eigen::Index>(s)));
  }
}

void EstimatorCorrection::passing_of_time(double elapsed_s, const Widths& widths, Eigen::VectorXd& keep,
                                          Eigen::VectorXd& growth) const {
  keep.setOnes();
  growth.setZero();
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    const double memory_s = i == parameters_.start() ? open_.start_memory_s : parameter.memory_s;
    if (memory_s > 0.0) {
      keep[i] = std::exp(-elapsed_s / memory_s);
      growth[i] = std::pow(width_of(parameter, widths) * parameter.deviation, 2.0) * (1.0 - keep[i] * keep[i]);
    } else {
      growth[i] = parameter.walk_per_root_s * parameter.walk_per_root_s * elapsed_s;
    }
  }
  const double offset_walk = options_.offset_walk_K_per_root_hour * options_.offset_walk_K_per_root_hour;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    growth[offset_at(static_cast<Eigen::Index>(s))] = offset_walk * elapsed_s / rom::seconds_per_hour;
  }
}

double EstimatorCorrection::width_of(const Parameter& parameter, const Widths& widths) {
  if (parameter.kind == ParameterKind::disturbance) return widths.disturbance;
  return parameter.kind == ParameterKind::environment ? widths.environment : 1.0;
}

void EstimatorCorrection::pass_time(double elapsed_s) {
  passing_of_time(elapsed_s, keep_, growth_);
  open_.disturbance =
      std::max(disturbance_idle_, open_.disturbance * std::exp(-elapsed_s / disturbance_width_memory_s));
  open_.environment = std::max(1.0, open_.environment * std::exp(-elapsed_s / environment_width_memory_s));
  filter_.pass_time(prior_mean_, keep_, growth_);
  note_curvature();
}

void EstimatorCorrection::note_curvature() {
  const double share = std::sqrt(0.5 * options_.curvature);
  for (Eigen::Index i = 0; i < curvature_.size(); ++i) {
    const bool bends = bends_the_state(parameters_.list()[static_cast<std::size_t>(i)].kind);
    curvature_[i] = bends ? share * filter_.deviation(i) * filter_.deviation(i) : 0.0;
  }
  // What is warmed or cooled otherwise than the shapes of the start say is another shape within minutes.
  const double left = std::exp(-std::max(0.0, times_.seen_s - open_.widened_s) / start_missed_memory_s);
  curvature_.tail(open_.start_missed.size()) = left * open_.start_missed;
}

double EstimatorCorrection::chi_square_of_readings() const {
  double left_K2 = 0.0, expected_K2 = 0.0;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    if (times_.seen_s - channels_[s].fused_s > consistency_.floor_memory_s()) continue;
    const double noise_K2 = std::pow(options_.sensors[s].noise_K, 2.0);
    left_K2 += noise_K2 + std::pow(consistency_.floor_K(static_cast<Eigen::Index>(s)), 2.0);
    expected_K2 += noise_K2 + std::pow(consistency_.least_floor_K(), 2.0);
  }
  return expected_K2 > 0.0 ? left_K2 / expected_K2 : 1.0;
}

void EstimatorCorrection::publish_deviations() {
  if (!standing_by_) chi_square_.note(parameters_, filter_, chi_square_of_readings());
  // A filter of straight lines publishes its P as it is: bounds are made with one.
  const double scale_factor = options_.curvature > 0.0 ? chi_square_.scale_factor() : 1.0;
  outputs_.evaluate(sensitivities_, filter_, {curvature_, scale_factor}, nodes_K_);
}

EstimatorStep EstimatorCorrection::step(const EstimatorSample& sample, double) {
  if (!started_) reset(sample.time_s, sample.nodes_K, sample.operating);
  if (standing_by_) {
    standing_by_ = false;
    times_.fused_s = sample.time_s;
    times_.due_s = sample.time_s + options_.period_s;
    for (SensorChannel& channel : channels_) channel.clear();
  }
  nodes_K_ = sample.nodes_K;
  const double elapsed_s = sample.time_s - times_.seen_s;
  times_.seen_s = sample.time_s;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    const auto index = static_cast<Eigen::Index>(s);
    channels_[s].predict(options_.sensors[s].row.dot(nodes_K_), elapsed_s, lag_s(index));
    if (sample.valid[index]) channels_[s].observe(sample.measured_K[index]);
  }
  const bool due = sample.time_s >= times_.due_s - due_slack_s;
  const bool fresh = sample.time_s < times_.fresh_until_s;
  if (due || fresh || period_.differs(sample.operating)) close_period(sample.time_s);
  if (start_unseen_) look_at_the_start();
  widen_films(sample.operating);
  EstimatorStep result;
  if (due) {
    result.corrected = result.state_corrected = update(sample.time_s);
    times_.due_s += options_.period_s;
    if (times_.due_s <= sample.time_s) times_.due_s = sample.time_s + options_.period_s;
  } else if (fresh && !is_held_) {
    publish_deviations();
  }
  publish_factors(sample.operating);
  if (!period_.is_open()) open_period(sample.time_s, sample.operating);
  if (second_pass_ && second_pass_->follow(*this, sample, due)) {
    take_over(second_pass_->result(), sample.operating);
    result.corrected = result.state_corrected = true;
  }
  return result;
}

void EstimatorCorrection::stand_by(double time_s, const Eigen::VectorXd& nodes, const rom::OperatingState& operating,
                                   double) {
  if (!started_) reset(time_s, nodes, operating);
  if (!standing_by_) {
    forget();
    filter_.set_mean(neutral_mean_);
    theta_.setZero();
    standing_by_ = true;
  }
  nodes_K_ = nodes;
  const double elapsed_s = time_s - times_.seen_s;
  times_.seen_s = time_s;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    channels_[s].predict(options_.sensors[s].row.dot(nodes_K_), elapsed_s, lag_s(static_cast<Eigen::Index>(s)));
  }
  sensitivities_.source_rises(nodes_K_, rises_K_);
  factors_.heat.setOnes();
  factors_.conductance.setOnes();
  factors_.node_heat_W.setZero();
  factors_.capacity_factor.setOnes();
  factors_.expansion = 1.0;
  bias_K_.setZero();
  if (time_s >= period_.opened_s() + options_.period_s - due_slack_s || time_s < times_.fresh_until_s ||
      period_.differs(operating)) {
    close_period(time_s);
    publish_deviations();
  }
  if (!period_.is_open()) open_period(time_s, operating);
}

double EstimatorCorrection::open_heat_W(Eigen::Index group) const {
  const int slot = parameters_.disturbance(group);
  return open_width * parameters_.list()[static_cast<std::size_t>(slot)].deviation;
}

FoundHeat EstimatorCorrection::unexplained_heat() const {
  FoundHeat surest;
  if (!parameters_.has_disturbances() || !heats_are_open()) return surest;
  double most_deviations = ParameterEstimate::significant;
  for (Eigen::Index group = 0; group < parameters_.group_count(); ++group) {
    const ParameterEstimate heat = estimate(parameters_.disturbance(group));
    if (!(std::abs(heat.value) > most_deviations * heat.deviation)) continue;
    most_deviations = std::abs(heat.value) / heat.deviation;
    surest = {group, heat.value, heat.deviation};
  }
  return surest;
}

void EstimatorCorrection::open_heats(const SquareRootFilter& other, const rom::OperatingState& operating) {
  open_.disturbance = std::max(open_.disturbance, open_width);
  adopt(other, operating);
}

void EstimatorCorrection::adopt(const SquareRootFilter& other, const rom::OperatingState& operating) {
  begin_another_record();
  made_.unknowns = filter_.mean();
  filter_.set_mean(other.mean());
  filter_.set_root(other.root());
  outputs_.clear_alternatives();
  follow_filter();
  publish_factors(operating);
  // What is held so far belongs to the old parameters; the period that begins here, to the new ones.
  period_.drop();
  open_period(times_.seen_s, operating);
}

}  // namespace spindle_twin::correction

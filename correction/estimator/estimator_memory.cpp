#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "correction/estimator/estimator_correction.hpp"

namespace spindle_twin::correction {
namespace {

// What a pause may have done unseen: of the rise that it had time for, 1 sigma of how much; what the shape of that rise
// may miss, because heat comes and goes in other ways; and how long both stay open.
constexpr double unseen_share = 0.5;
constexpr double unseen_shape = 0.2;
constexpr double unseen_memory_s = 600.0;

constexpr std::size_t per_channel = 2;  // lag slope, floor
constexpr std::size_t of_start = 3;     // and one per start parameter

bool fits(const std::vector<double>& numbers, std::size_t count) {
  return numbers.size() == count &&
         std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

}  // namespace

void EstimatorCorrection::save(EstimatorState& state) const {
  const auto n = static_cast<std::size_t>(filter_.size());
  const auto p = static_cast<std::size_t>(parameters_.count());
  const auto copy = [](const auto& numbers, std::vector<double>& to, std::size_t at) {
    for (Eigen::Index i = 0; i < numbers.size(); ++i) to[at + static_cast<std::size_t>(i)] = numbers[i];
  };
  state.mean.resize(n);
  state.root.resize(n * n);
  state.sensitivities.resize(static_cast<std::size_t>(sensitivities_.transposed().size()));
  state.lagged.resize(channels_.size() * p);
  state.channels.resize(channels_.size() * per_channel);
  state.start.resize(of_start + static_cast<std::size_t>(open_.start_missed.size()));
  copy(filter_.mean(), state.mean, 0);
  copy(filter_.root().reshaped(), state.root, 0);
  copy(sensitivities_.transposed().reshaped(), state.sensitivities, 0);
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    copy(channels_[s].sensitivity(), state.lagged, s * p);
    state.channels[s * per_channel] = channels_[s].lag_slope_K_per_s();
    state.channels[s * per_channel + 1] = consistency_.floor_K(static_cast<Eigen::Index>(s));
  }
  state.start[0] = open_.start_memory_s;
  state.start[1] = open_.widened_s - times_.seen_s;
  state.start[2] = open_.disturbance;
  copy(open_.start_missed, state.start, of_start);
  state.scale.resize(n);
  copy(filter_.scale(), state.scale, 0);
  state.nominal.resize(n, 1.0);
  for (std::size_t i = 0; i < p; ++i) state.nominal[i] = parameters_.list()[i].nominal;
  state.knows_calibration = knows_calibration_;
  state.determined = chi_square_.determined();
}

bool EstimatorCorrection::restore(const EstimatorState& state) {
  const auto n = static_cast<std::size_t>(filter_.size());
  const auto p = static_cast<std::size_t>(parameters_.count());
  if (!started_ || !fits(state.mean, n) || !fits(state.root, n * n) || !fits(state.lagged, channels_.size() * p) ||
      !fits(state.sensitivities, static_cast<std::size_t>(sensitivities_.transposed().size())) ||
      !fits(state.channels, channels_.size() * per_channel) ||
      !fits(state.start, of_start + static_cast<std::size_t>(open_.start_missed.size())) ||
      (!state.scale.empty() && !fits(state.scale, n)) || !(state.determined >= 0.0) ||
      !std::isfinite(state.determined)) {
    return false;
  }
  const auto size = static_cast<Eigen::Index>(n);
  filter_.set_mean(Eigen::Map<const Eigen::VectorXd>(state.mean.data(), size));
  Eigen::MatrixXd root = Eigen::Map<const Eigen::MatrixXd>(state.root.data(), size, size);
  if (!state.scale.empty()) {  // other deviations of the priors since: the covariance is the same
    root =
        Eigen::Map<const Eigen::VectorXd>(state.scale.data(), size).cwiseQuotient(filter_.scale()).asDiagonal() * root;
  }
  filter_.set_root(root);
  knows_calibration_ = state.knows_calibration;
  chi_square_.set_determined(state.determined);
  sensitivities_.set_transposed(Eigen::Map<const Eigen::MatrixXd>(
      state.sensitivities.data(), sensitivities_.transposed().rows(), coordinates_->nodes()));
  theta_ = filter_.mean().head(parameters_.count());
  factors_.expansion = parameters_.expansion_factor(theta_);
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    const Eigen::VectorXd shown = Eigen::Map<const Eigen::VectorXd>(state.lagged.data() + s * p, parameters_.count());
    channels_[s].restore(shown, state.channels[s * per_channel]);
    consistency_.set_floor(static_cast<Eigen::Index>(s), state.channels[s * per_channel + 1]);
    const Eigen::Index b = offset_at(static_cast<Eigen::Index>(s));
    records_[s].offset_K = filter_.mean()[b];
    records_[s].offset_deviation_K = filter_.deviation(b);
  }
  open_.start_memory_s = state.start[0];
  open_.widened_s = times_.seen_s + state.start[1];
  open_.disturbance = state.start[2];
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    if (parameter.kind != ParameterKind::environment || !(parameter.deviation > 0.0)) continue;
    open_.environment = std::max(open_.environment, filter_.deviation(i) / parameter.deviation);
  }
  open_.start_missed = Eigen::Map<const Eigen::VectorXd>(state.start.data() + of_start, open_.start_missed.size());
  start_unseen_ = false;
  begin_another_record();
  note_curvature();
  publish_deviations();
  return true;
}

void EstimatorCorrection::widen_start(double time_s, const Eigen::VectorXd& nodes, const Eigen::VectorXd& rise_K) {
  const Eigen::Index start = parameters_.start();
  if (start < 0) return;
  nodes_K_ = nodes;
  close_period(time_s);
  const double deviation = parameters_.list()[static_cast<std::size_t>(start)].deviation;
  // What was open of the start before adds to it, node by node.
  const Eigen::ArrayXd before_K = filter_.deviation(start) * sensitivities_.in_kelvin().col(start).array();
  const Eigen::ArrayXd heated_K = unseen_share * rise_K.array();
  sensitivities_.set_start((heated_K.square() + before_K.square()).sqrt().matrix() / deviation, parameters_);
  keep_.setOnes();
  growth_.setZero();
  keep_[start] = 0.0;
  growth_[start] = deviation * deviation;
  filter_.pass_time(prior_mean_, keep_, growth_);
  theta_ = filter_.mean().head(parameters_.count());
  begin_another_record();
  open_.start_memory_s = unseen_memory_s;
  open_.start_missed.setZero();
  open_.start_missed[0] = unseen_shape * deviation;
  open_.widened_s = time_s;
  times_.fresh_until_s = time_s + fresh_s;
  for (SensorChannel& channel : channels_) {
    sensitivities_.of_row(channel.internal(), place_);
    channel.set_sensitivity_at(start, place_[start]);
  }
  note_curvature();
  publish_deviations();
}

std::vector<std::string> EstimatorCorrection::unknowns() const {
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters_.list()) names.push_back(parameter.name);
  for (const EstimatorSensor& sensor : options_.sensors) names.push_back("offset " + sensor.name);
  if (!has_lags()) return names;
  for (const EstimatorSensor& sensor : options_.sensors) names.push_back("lag " + sensor.name);
  return names;
}

bool EstimatorCorrection::stays(Eigen::Index unknown) const {
  if (unknown >= parameters_.count()) return has_lags() && unknown >= lag_at(0);
  return is_of_the_machine(parameters_.list()[static_cast<std::size_t>(unknown)].kind);
}

std::optional<KnownParameters> known_from(std::vector<std::string> unknowns, const EstimatorState& state) {
  const std::size_t count = unknowns.size();
  if (count == 0 || !fits(state.mean, count) || !fits(state.scale, count) || !fits(state.root, count * count) ||
      !fits(state.nominal, count)) {
    return std::nullopt;
  }
  const auto n = static_cast<Eigen::Index>(count);
  const auto vector = [n](const std::vector<double>& of) { return Eigen::Map<const Eigen::VectorXd>(of.data(), n); };
  const Eigen::MatrixXd root =
      vector(state.scale).asDiagonal() * Eigen::Map<const Eigen::MatrixXd>(state.root.data(), n, n);
  return KnownParameters{std::move(unknowns), vector(state.mean), root * root.transpose(), vector(state.nominal)};
}

int EstimatorCorrection::begin_with(const KnownParameters& known) {
  const auto n = static_cast<Eigen::Index>(known.names.size());
  if (known.mean.size() != n || known.covariance.rows() != n || known.covariance.cols() != n ||
      (known.nominal.size() != 0 && known.nominal.size() != n) || !known.mean.allFinite() ||
      !known.covariance.allFinite()) {
    return 0;
  }
  const std::vector<std::string> own = unknowns();
  std::vector<Eigen::Index> here, there;
  for (Eigen::Index i = 0; i < filter_.size(); ++i) {
    const auto found = std::find(known.names.begin(), known.names.end(), own[static_cast<std::size_t>(i)]);
    if (!stays(i) || found == known.names.end()) continue;
    here.push_back(i);
    there.push_back(found - known.names.begin());
  }
  if (here.empty()) return 0;
  Eigen::VectorXd mean = prior_mean_;
  Eigen::MatrixXd covariance = prior_.covariance();
  Eigen::VectorXd less = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(here.size()));
  for (std::size_t k = 0; k < here.size(); ++k) {
    const Eigen::Index i = here[k], j = there[k];
    const bool has_nominal = i < parameters_.count() && known.nominal.size() == n;
    mean[i] = known.mean[j];
    if (has_nominal) {
      mean[i] += nominal_shift(known.nominal[j], parameters_.list()[static_cast<std::size_t>(i)].nominal);
    }
    less[static_cast<Eigen::Index>(k)] = std::min(1.0, std::sqrt(covariance(i, i) / known.covariance(j, j)));
    covariance.row(i).setZero();
    covariance.col(i).setZero();
  }
  covariance(here, here) = less.asDiagonal() * known.covariance(there, there) * less.asDiagonal();
  const Eigen::VectorXd inverse = prior_.scale().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> root(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  if (root.info() != Eigen::Success || !mean.allFinite()) return 0;
  bound(mean);
  known_mean_ = mean;
  known_root_ = root.matrixL();
  return static_cast<int>(here.size());
}

/// Once: a start after that one knows nothing again.
void EstimatorCorrection::begin_with_what_is_known() {
  if (known_mean_.size() == 0) return;
  filter_.set_mean(known_mean_);
  filter_.set_root(known_root_);
  theta_ = known_mean_.head(parameters_.count());
  note_curvature();
  known_mean_.resize(0);
  known_root_.resize(0, 0);
}

}  // namespace spindle_twin::correction

#include "correction/calibrate/stepped_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double gamma = 1.0 - 1.0 / std::numbers::sqrt2;
constexpr double newton_K = 1e-9;         // last correction, capacity-weighted rms
constexpr double slow_contraction = 0.1;  // of Newton's corrections, from which its matrix is made anew
constexpr int most_iterations = 25;
constexpr double environment_step_K = 0.01;  // of the difference quotients

bool reads_environment(const rom::LawTerm& term) {
  return term.bound.first.environment >= 0 || term.bound.second.environment >= 0;
}

}  // namespace

SteppedState::SteppedState(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> coordinates,
                           const ParameterModel& parameters, const Eigen::VectorXd& theta)
    : network_(network),
      parameters_(parameters),
      coordinates_(std::move(coordinates)),
      theta_(theta),
      rhs_(coordinates_),
      derivatives_(network, coordinates_, parameters),
      sources_(network.source_distribution),
      operating_(network.boundaries.operating),
      factors_(parameters.make_factors(network)),
      values_(rom::make_boundary_values(network.boundaries)),
      bias_K_(Eigen::VectorXd::Zero(coordinates_->environments())),
      rises_K_(Eigen::VectorXd::Zero(coordinates_->sources())),
      nodes_K_(Eigen::VectorXd::Zero(coordinates_->nodes())),
      x_(nodes_K_),
      rate_(nodes_K_) {
  if (sources_.cols() > 0) coordinates_->capacity_root().triangularView<Eigen::Lower>().solveInPlace(sources_);
  const std::vector<rom::LawTerm>& laws = coordinates_->laws().list();
  laws_read_environments_ = std::any_of(laws.begin(), laws.end(), reads_environment);
  matrix_.resize(coordinates_->nodes(), coordinates_->nodes());
  parameters_.apply(theta_, 0.0, rises_K_, factors_, bias_K_);
}

void SteppedState::start(double start_K) {
  nodes_K_.setConstant(start_K);
  for (std::size_t k = 0; k < parameters_.shapes().size(); ++k) {
    nodes_K_ += theta_[parameters_.start() + static_cast<Eigen::Index>(k)] * parameters_.shapes()[k].rise_K;
  }
  coordinates_->to_internal(nodes_K_, x_);
  derivatives_.start(parameters_);
  sensitivities_ = derivatives_.transposed().topRows(parameters_.count()).transpose();
  factored_s_ = 0.0;
}

Eigen::VectorXd SteppedState::internal_row(const Eigen::VectorXd& row) const {
  return coordinates_->capacity_root().triangularView<Eigen::Lower>().solve(row);
}

/// f(x), with the inputs that x makes in values_.
void SteppedState::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& rate) {
  coordinates_->to_temperatures(x, nodes_K_);
  derivatives_.source_rises(nodes_K_, rises_K_);
  parameters_.apply(theta_, operating_.speed_rpm, rises_K_, factors_, bias_K_);
  rom::evaluate_boundaries(network_.boundaries, operating_, factors_, values_);
  rhs_.follow(values_, x.data());
  rhs_.evaluate(x.data(), rate.data());
}

/// 1 + γhA at x, which must have been evaluated last; values_ then hold the laws' values there.
void SteppedState::factor(double weight_s, const Eigen::VectorXd& x) {
  rhs_.linearise(x.data(), matrix_);
  coordinates_->laws().at_temperatures(nodes_K_, values_);
  const int bearing = parameters_.bearing();
  const double loss_per_K = bearing < 0 ? 0.0 : theta_[bearing];
  for (Eigen::Index i = 0; i < sources_.cols(); ++i) {
    if (!parameters_.is_friction(i) || loss_per_K == 0.0) continue;
    Eigen::VectorXd falls = loss_per_K * values_.heat_W[i] * sources_.col(i);
    if (values_.capacity_factor.size() > 0) falls.array() /= values_.capacity_factor.array();
    matrix_.noalias() += falls * sources_.col(i).transpose();
  }
  matrix_ *= weight_s;
  matrix_.diagonal().array() += 1.0;
  lu_.compute(matrix_);
  factored_s_ = weight_s;
}

/// Y = from + γh f(Y) from a first guess in `stage` on.
bool SteppedState::solve_stage(double weight_s, const Eigen::VectorXd& from, Eigen::VectorXd& stage) {
  const double scale =
      coordinates_->internal_per_kelvin() * std::sqrt(static_cast<double>(coordinates_->nodes())) * newton_K;
  double before = std::numeric_limits<double>::infinity();
  bool fresh = false;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    evaluate(stage, rate_);
    if (factored_s_ != weight_s) {
      factor(weight_s, stage);
      fresh = true;
    }
    const Eigen::VectorXd step = lu_.solve(from + weight_s * rate_ - stage);
    stage += step;
    const double size = step.norm();
    if (!std::isfinite(size)) return false;
    if (size <= scale) return true;
    if (size > slow_contraction * before && !fresh) factored_s_ = 0.0;
    fresh = false;
    before = size;
  }
  return false;
}

/// S of a stage that was solved, in place of S of what it started from.
void SteppedState::solve_sensitivities(double weight_s, const Eigen::VectorXd& stage, Eigen::MatrixXd& from) {
  evaluate(stage, rate_);
  factor(weight_s, stage);
  drive(stage);
  from += weight_s * drive_;
  from = lu_.solve(from);
}

/// ∂f/∂θ at x, at which values_ and rate_ are.
void SteppedState::drive(const Eigen::VectorXd& x) {
  const HeldInterval here{1.0, operating_.speed_rpm, nodes_K_, nodes_K_, values_, theta_};
  drive_ = derivatives_.drive_at(here, parameters_);
  const Eigen::VectorXd& capacity_factor = values_.capacity_factor;
  for (Eigen::Index i = 0; i < drive_.rows() && parameters_.has_capacities(); ++i) {
    drive_.row(i) /= capacity_factor[i];
    drive_(i, parameters_.capacity(i)) = -rate_[i];
  }
  if (laws_read_environments_) drive_by_environments(x);
}

/// Where laws read environments, a bias acts through heats and conductances too.
void SteppedState::drive_by_environments(const Eigen::VectorXd& x) {
  const rom::BoundaryValues here = values_;
  Eigen::VectorXd above = rate_, below = rate_;
  for (Eigen::Index e = 0; e < coordinates_->environments(); ++e) {
    const int slot = parameters_.environment(e);
    if (slot < 0) continue;
    rom::BoundaryValues moved = here;
    moved.environment_K[e] = here.environment_K[e] + environment_step_K;
    rhs_.follow(moved, x.data());
    rhs_.evaluate(x.data(), above.data());
    moved.environment_K[e] = here.environment_K[e] - environment_step_K;
    rhs_.follow(moved, x.data());
    rhs_.evaluate(x.data(), below.data());
    drive_.col(slot) = (above - below) / (2.0 * environment_step_K);
  }
}

bool SteppedState::advance(double period_s, const rom::OperatingState& operating) {
  operating_ = operating;
  operating_.environment_K += bias_K_;
  const double weight_s = gamma * period_s;
  Eigen::VectorXd stage = x_;
  if (!solve_stage(weight_s, x_, stage)) return false;
  Eigen::MatrixXd stage_sensitivities = sensitivities_;
  solve_sensitivities(weight_s, stage, stage_sensitivities);

  const Eigen::VectorXd from = x_ + ((1.0 - gamma) / gamma) * (stage - x_);
  x_ += (stage - x_) / gamma;
  if (!solve_stage(weight_s, from, x_)) return false;
  sensitivities_ += ((1.0 - gamma) / gamma) * (stage_sensitivities - sensitivities_);
  solve_sensitivities(weight_s, x_, sensitivities_);
  return x_.allFinite() && sensitivities_.allFinite();
}

}  // namespace spindle_twin::correction

#include "correction/paper/paper_correction.hpp"

#include <cmath>
#include <utility>

#include "correction/paper/check_options.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::correction {

std::vector<HeatGroup> common_heat_group(const rom::Network& network) {
  HeatGroup group{"all", {}, {}};
  for (std::size_t k = 0; k < network.key_points.size(); ++k) group.key_points.push_back(static_cast<int>(k));
  for (std::size_t s = 0; s < network.boundaries.sources.size(); ++s) group.sources.push_back(static_cast<int>(s));
  return {group};
}

PaperCorrection::PaperCorrection(const rom::Network& network, PaperOptions options, const StepperFactory& make_stepper)
    : network_(&network),
      options_(std::move(options)),
      joints_(network),
      window_(static_cast<Eigen::Index>(network.key_points.size())),
      factors_(rom::no_correction(network.boundaries)) {
  if (options_.groups.empty()) options_.groups = common_heat_group(network);
  check_options(network, options_);
  const auto key_points = static_cast<Eigen::Index>(network.key_points.size());
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  std::shared_ptr<const rom::NetworkOperator> coordinates;
  if (rom::has_physics(network.boundaries)) coordinates = std::make_shared<const rom::NetworkOperator>(network);
  rescaled_K_ = base_nodes_K_ = Eigen::VectorXd::Zero(nodes);
  start_K_ = Eigen::VectorXd::Zero(key_points);
  key_point_rows_.resize(key_points, nodes);
  for (Eigen::Index k = 0; k < key_points; ++k) {
    key_point_rows_.row(k) = network.key_points[static_cast<std::size_t>(k)].row.transpose();
  }
  for (const HeatGroup& members : options_.groups) {
    groups_.push_back({HeatLaw(members), BaseResponse(network, coordinates, make_stepper(), members.sources),
                       Eigen::VectorXd::Zero(nodes)});
  }
}

void PaperCorrection::reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating) {
  for (Group& group : groups_) {
    group.base.set_temperatures(nodes_K);
    group.heat.wait();
  }
  start_K_.noalias() = key_point_rows_ * nodes_K;
  due_s_ = time_s + options_.period_s;
  operating_.reset(operating);
  started_ = true;
  clear_window();
}

void PaperCorrection::clear_window() {
  window_.clear();
  for (Group& group : groups_) group.base.clear_window();
}

bool PaperCorrection::correct_heats(const PaperSample& sample) {
  const double ambient_K =
      rom::first_environment_K(network_->boundaries, rom::EnvironmentKind::ambient, sample.operating)
          .value_or(network_->boundaries.reference_temperature_K);
  const HeatInstant instant{sample.operating.speed_rpm, operating_.since_s(sample.time_s), ambient_K, start_K_};
  bool moved = false;
  for (Group& group : groups_) {
    if (!group.heat.correct(options_, window_, group.base, instant)) continue;
    moved = true;
    for (const int source : group.heat.members().sources) factors_.heat[source] = group.heat.factor();
  }
  return moved;
}

/// By superposition each group's own rise scales with its heat, in the model and in the bases of the other groups.
void PaperCorrection::rescale_state(const Eigen::VectorXd& nodes_K) {
  rescaled_K_ = nodes_K;
  for (Group& group : groups_) {
    group.own_rise_K = nodes_K - group.base.temperatures_K();
    rescaled_K_ += (group.heat.step() - 1.0) * group.own_rise_K;
  }
  if (groups_.size() == 1) return;  // the only base holds none of the rescaled heat
  for (Group& group : groups_) {
    base_nodes_K_ = rescaled_K_ - group.heat.step() * group.own_rise_K;
    group.base.set_temperatures(base_nodes_K_);
  }
}

PaperStep PaperCorrection::correct(const PaperSample& sample) {
  PaperStep result;
  bool heat_moved = false;
  if (options_.heat_law) {
    heat_moved = correct_heats(sample);
  } else {
    for (Group& group : groups_) group.heat.pass();
  }
  if (options_.state_rescale && heat_moved) {
    rescale_state(sample.nodes_K);
    result.state_rescaled = true;
  }
  const bool stands = std::abs(sample.operating.speed_rpm) < options_.guards.standstill_rpm;
  const bool joints_moved =
      options_.joint_law && !stands && joints_.correct(options_, window_, sample.nodes_K, factors_);
  result.corrected = heat_moved || joints_moved;
  return result;
}

void PaperCorrection::advance_bases(const rom::OperatingState& operating, const Eigen::VectorXd& nodes_K,
                                    double advance_s) {
  for (Group& group : groups_) group.base.advance(operating, factors_, nodes_K, advance_s);
}

PaperStep PaperCorrection::step(const PaperSample& sample, double advance_s) {
  if (!started_) reset(sample.time_s, sample.nodes_K, sample.operating);
  operating_.watch(sample.time_s, sample.operating, options_.guards);
  const bool due = sample.time_s >= due_s_ - time_slack_s;
  if (due || sample.time_s > due_s_ - options_.window_s + time_slack_s) {
    window_.add(sample.measured_K, sample.valid, sample.predicted_K);
    for (Group& group : groups_) group.base.add_to_window(key_point_rows_);
  }
  PaperStep result;
  if (due) {
    result = correct(sample);
    clear_window();
    due_s_ += options_.period_s;
    if (due_s_ <= sample.time_s) due_s_ = sample.time_s + options_.period_s;
  }
  advance_bases(sample.operating, sample.nodes_K, advance_s);
  return result;
}

void PaperCorrection::stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating,
                               double advance_s) {
  if (!started_) reset(time_s, nodes_K, operating);
  operating_.watch(time_s, operating, options_.guards);
  factors_.heat.setOnes();
  factors_.conductance.setOnes();
  for (Group& group : groups_) group.heat.stand_by();
  clear_window();
  due_s_ = time_s + advance_s + options_.period_s;
  advance_bases(operating, nodes_K, advance_s);
}

}  // namespace spindle_twin::correction

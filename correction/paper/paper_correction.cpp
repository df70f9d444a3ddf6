#include "correction/paper/paper_correction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "correction/paper/check_options.hpp"
#include "correction/paper/joint_law.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/integrate/network_operator.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double time_slack_s = 1e-6;  // a period of 80 cycles of 1 s must not slip by rounding
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Running sums over the window, one entry per key point.
struct Window {
  Eigen::VectorXd measured_K;
  Eigen::VectorXd predicted_K;
  Eigen::VectorXi valid_samples;
  int samples = 0;

  void clear() {
    measured_K.setZero();
    predicted_K.setZero();
    valid_samples.setZero();
    samples = 0;
  }
};

struct Group {
  HeatGroup members;
  std::unique_ptr<rom::Stepper> base;
  rom::CorrectionFactors base_factors;          ///< the common factors with this group's heat off
  Eigen::VectorXd base_sum_K;                   ///< window sum per key point
  Eigen::VectorXd measured_K, model_K, zero_K;  ///< the group's valid sensors, first entries used
  Eigen::VectorXd own_rise_K;                   ///< per node, used while the state is rescaled
  bool base_failed = false;
  double factor = 1.0;
  double step = 1.0;
  double ratio = 1.0;
  double rise_K = 0.0;
  Freeze freeze = Freeze::waiting;
};

}  // namespace

std::vector<HeatGroup> common_heat_group(const rom::Network& network) {
  HeatGroup group{"all", {}, {}};
  for (std::size_t k = 0; k < network.key_points.size(); ++k) group.key_points.push_back(static_cast<int>(k));
  for (std::size_t s = 0; s < network.boundaries.sources.size(); ++s) group.sources.push_back(static_cast<int>(s));
  return {group};
}

PaperGuards no_guards() {
  PaperGuards guards;
  guards.reading_uncertainty_K = 0.0;
  guards.minimum_rise_K = 0.0;
  guards.step_minimum = guards.heat_minimum = guards.resistance_minimum = 0.0;
  guards.step_maximum = guards.heat_maximum = guards.resistance_maximum = guards.resistance_step = infinite;
  guards.minimum_sensors = 1;
  guards.settle_s = 0.0;
  guards.standstill_rpm = 0.0;
  guards.deadband = false;
  return guards;
}

struct PaperCorrection::Impl {
  Impl(const rom::Network& the_network, PaperOptions the_options, const StepperFactory& make_stepper)
      : network(the_network), options(std::move(the_options)) {
    if (options.groups.empty()) options.groups = common_heat_group(network);
    check_options(network, options);
    const auto key_points = static_cast<Eigen::Index>(network.key_points.size());
    const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
    if (rom::has_physics(network.boundaries)) coordinates.emplace(network);
    factors = rom::no_correction(network.boundaries);
    values = rom::make_boundary_values(network.boundaries);
    rescaled_K = base_nodes_K = Eigen::VectorXd::Zero(nodes);
    start_K = Eigen::VectorXd::Zero(key_points);
    base_now_K = Eigen::VectorXd::Zero(key_points);
    part_shift_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.parts.size()));
    part_sensors = Eigen::VectorXi::Zero(part_shift_K.size());
    window = {Eigen::VectorXd::Zero(key_points), Eigen::VectorXd::Zero(key_points), Eigen::VectorXi::Zero(key_points),
              0};
    key_point_rows.resize(key_points, nodes);
    for (Eigen::Index k = 0; k < key_points; ++k) {
      const rom::KeyPoint& point = network.key_points[static_cast<std::size_t>(k)];
      key_point_rows.row(k) = point.row.transpose();
      const auto part = std::find_if(network.parts.begin(), network.parts.end(),
                                     [&](const rom::PartOutput& output) { return output.name == point.part; });
      part_of_key_point.push_back(part == network.parts.end() ? -1 : static_cast<int>(part - network.parts.begin()));
    }
    for (const HeatGroup& members : options.groups) {
      Group group;
      group.members = members;
      group.base = make_stepper();
      group.base_factors = factors;
      group.base_sum_K = group.measured_K = group.model_K = group.zero_K = Eigen::VectorXd::Zero(key_points);
      group.own_rise_K = Eigen::VectorXd::Zero(nodes);
      groups.push_back(std::move(group));
    }
  }

  void reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating) {
    for (Group& group : groups) {
      group.base->set_temperatures(nodes_K);
      group.freeze = Freeze::waiting;
      group.base_failed = false;
    }
    start_K.noalias() = key_point_rows * nodes_K;
    due_s = time_s + options.period_s;
    changed_s = -infinite;
    anchor_speed_rpm = operating.speed_rpm;
    anchor_load = operating.load;
    started = true;
    clear_window();
  }

  void clear_window() {
    window.clear();
    for (Group& group : groups) {
      group.base_sum_K.setZero();
      group.base_failed = false;
    }
  }

  void watch_operating(double time_s, const rom::OperatingState& operating) {
    if (std::abs(operating.speed_rpm - anchor_speed_rpm) <= options.guards.speed_change_rpm &&
        std::abs(operating.load - anchor_load) <= options.guards.load_change) {
      return;
    }
    anchor_speed_rpm = operating.speed_rpm;
    anchor_load = operating.load;
    changed_s = time_s;
  }

  void observe(const PaperSample& sample) {
    ++window.samples;
    window.predicted_K += sample.predicted_K;
    for (Eigen::Index k = 0; k < sample.measured_K.size(); ++k) {
      if (!sample.valid[k] || !std::isfinite(sample.measured_K[k])) continue;
      window.measured_K[k] += sample.measured_K[k];
      ++window.valid_samples[k];
    }
    for (Group& group : groups) {
      base_now_K.noalias() = key_point_rows * group.base->temperatures_K();
      group.base_sum_K += base_now_K;
    }
  }

  /// Fills the group's sensor lists with window means; returns how many are valid over the whole window.
  Eigen::Index gather(Group& group, const rom::OperatingState& operating) const {
    Eigen::Index count = 0;
    const double samples = window.samples;
    for (const int key_point : group.members.key_points) {
      if (window.valid_samples[key_point] < window.samples) continue;
      group.measured_K[count] = window.measured_K[key_point] / samples;
      group.model_K[count] = window.predicted_K[key_point] / samples;
      switch (options.form) {
        case RatioForm::consistent:
          group.zero_K[count] = group.base_sum_K[key_point] / samples;
          break;
        case RatioForm::as_printed_eq3:
          group.zero_K[count] = ambient_K(operating);
          break;
        default:
          group.zero_K[count] = start_K[key_point];
      }
      ++count;
    }
    return count;
  }

  double ambient_K(const rom::OperatingState& operating) const {
    return rom::first_environment_K(network.boundaries, rom::EnvironmentKind::ambient, operating)
        .value_or(network.boundaries.reference_temperature_K);
  }

  /// Sets group.step, ratio, rise and the reason if nothing moves.
  Freeze correct_heat(Group& group, const PaperSample& sample) const {
    const PaperGuards& guards = options.guards;
    group.step = 1.0;
    group.ratio = 1.0;
    group.rise_K = 0.0;
    const Eigen::Index sensors = gather(group, sample.operating);
    if (group.base_failed) return Freeze::base_failed;
    if (std::abs(sample.operating.speed_rpm) < guards.standstill_rpm) return Freeze::standstill;
    if (sample.time_s - changed_s < guards.settle_s - time_slack_s) return Freeze::operating_changed;
    const auto wanted =
        std::min<Eigen::Index>(guards.minimum_sensors, static_cast<Eigen::Index>(group.members.key_points.size()));
    if (sensors < wanted) return Freeze::too_few_sensors;

    const RiseRatio found = rise_ratio(options.form, group.measured_K.head(sensors), group.model_K.head(sensors),
                                       group.zero_K.head(sensors));
    group.rise_K = found.model_rise_K;
    const double smallest_K = std::max(10.0 * guards.reading_uncertainty_K, guards.minimum_rise_K);
    if (std::abs(found.model_rise_K) < smallest_K || std::abs(found.measured_rise_K) < smallest_K) {
      return Freeze::small_rise;
    }
    if (!std::isfinite(found.ratio)) return Freeze::negative_ratio;
    group.ratio = found.ratio;
    const bool additive = options.form == RatioForm::as_printed_additive;
    if (found.ratio < 0.0 || (found.ratio == 0.0 && !additive)) return Freeze::negative_ratio;
    if (guards.deadband &&
        std::abs(std::log(found.ratio)) < guards.reading_uncertainty_K / std::abs(found.measured_rise_K)) {
      return Freeze::deadband;
    }
    const double step = std::clamp(std::pow(found.ratio, options.relaxation), guards.step_minimum, guards.step_maximum);
    const double factor = std::clamp(group.factor * step, guards.heat_minimum, guards.heat_maximum);
    if (factor == group.factor) return Freeze::at_limit;
    group.step = factor / group.factor;
    group.factor = factor;
    return Freeze::none;
  }

  bool correct_joints(const PaperSample& sample) {
    if (std::abs(sample.operating.speed_rpm) < options.guards.standstill_rpm) return false;
    shift_parts_by_sensors();
    const auto rise_K = [&](int part) {
      return network.parts[static_cast<std::size_t>(part)].mean_row.dot(sample.nodes_K) + part_shift_K[part] -
             network.boundaries.reference_temperature_K;
    };
    bool moved = false;
    const auto& conductances = network.boundaries.conductances;
    for (std::size_t j = 0; j < conductances.size(); ++j) {
      const rom::Conductance& joint = conductances[j];
      if (!joint.fit || joint.part_a < 0 || joint.part_b < 0) continue;
      const double wanted =
          1.0 / joint_resistance_ratio(*joint.fit, rise_K(joint.part_a), rise_K(joint.part_b), options.joint_exponent,
                                       options.guards.resistance_minimum, options.guards.resistance_maximum);
      double& factor = factors.conductance[static_cast<Eigen::Index>(j)];
      const double limited =
          std::clamp(wanted, factor / options.guards.resistance_step, factor * options.guards.resistance_step);
      if (!std::isfinite(limited) || limited == factor) continue;
      factor = limited;
      moved = true;
    }
    return moved;
  }

  void shift_parts_by_sensors() {
    part_shift_K.setZero();
    part_sensors.setZero();
    for (std::size_t k = 0; k < part_of_key_point.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const int part = part_of_key_point[k];
      if (part < 0 || window.valid_samples[row] < window.samples) continue;
      part_shift_K[part] += (window.measured_K[row] - window.predicted_K[row]) / window.samples;
      ++part_sensors[part];
    }
    part_shift_K.array() /= part_sensors.array().max(1).cast<double>();
  }

  /// By superposition each group's own rise scales with its heat, in the model and in the bases of the other groups.
  void rescale_state(const PaperSample& sample) {
    rescaled_K = sample.nodes_K;
    for (Group& group : groups) {
      group.own_rise_K = sample.nodes_K - group.base->temperatures_K();
      rescaled_K += (group.step - 1.0) * group.own_rise_K;
    }
    if (groups.size() == 1) return;  // the only base holds none of the rescaled heat
    for (Group& group : groups) {
      base_nodes_K = rescaled_K - group.step * group.own_rise_K;
      group.base->set_temperatures(base_nodes_K);
    }
  }

  PaperStep correct(const PaperSample& sample) {
    PaperStep result;
    bool heat_moved = false;
    for (Group& group : groups) {
      group.freeze = options.heat_law ? correct_heat(group, sample) : Freeze::none;
      if (group.freeze != Freeze::none || group.step == 1.0) continue;
      heat_moved = true;
      for (const int source : group.members.sources) factors.heat[source] = group.factor;
    }
    if (options.state_rescale && heat_moved) {
      rescale_state(sample);
      result.state_rescaled = true;
    }
    const bool joints_moved = options.joint_law && correct_joints(sample);
    result.corrected = heat_moved || joints_moved;
    return result;
  }

  /// `nodes_K`: of the corrected network. Superposition holds for heats and conductances that do not depend on which of
  /// two solutions is asked, so the bases hold what physical laws are at the network's temperatures.
  void advance_bases(const rom::OperatingState& operating, const Eigen::VectorXd& nodes_K, double advance_s) {
    for (Group& group : groups) {
      group.base_factors.heat = factors.heat;
      group.base_factors.conductance = factors.conductance;
      for (const int source : group.members.sources) group.base_factors.heat[source] = 0.0;
      rom::evaluate_boundaries(network.boundaries, operating, group.base_factors, values);
      if (coordinates) coordinates->laws().at_temperatures(nodes_K, values);
      values.laws.follow = false;
      if (group.base->advance(advance_s, values) != rom::StepStatus::ok) group.base_failed = true;
    }
  }

  PaperStep step(const PaperSample& sample, double advance_s) {
    if (!started) reset(sample.time_s, sample.nodes_K, sample.operating);
    watch_operating(sample.time_s, sample.operating);
    const bool due = sample.time_s >= due_s - time_slack_s;
    if (due || sample.time_s > due_s - options.window_s + time_slack_s) observe(sample);
    PaperStep result;
    if (due) {
      result = correct(sample);
      clear_window();
      due_s += options.period_s;
      if (due_s <= sample.time_s) due_s = sample.time_s + options.period_s;
    }
    advance_bases(sample.operating, sample.nodes_K, advance_s);
    return result;
  }

  void stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating, double advance_s) {
    if (!started) reset(time_s, nodes_K, operating);
    watch_operating(time_s, operating);
    factors.heat.setOnes();
    factors.conductance.setOnes();
    for (Group& group : groups) {
      group.factor = group.step = group.ratio = 1.0;
      group.rise_K = 0.0;
      group.freeze = Freeze::waiting;
    }
    clear_window();
    due_s = time_s + advance_s + options.period_s;
    advance_bases(operating, nodes_K, advance_s);
  }

  const rom::Network& network;
  PaperOptions options;
  std::optional<const rom::NetworkOperator> coordinates;  // of a network with physical laws
  rom::CorrectionFactors factors;
  rom::BoundaryValues values;
  std::vector<Group> groups;
  Window window;
  Eigen::MatrixXd key_point_rows;
  std::vector<int> part_of_key_point;
  Eigen::VectorXd rescaled_K, base_nodes_K, start_K, base_now_K, part_shift_K;
  Eigen::VectorXi part_sensors;
  double due_s = 0.0;
  double changed_s = -infinite;
  double anchor_speed_rpm = 0.0;
  double anchor_load = 0.0;
  bool started = false;
};

PaperCorrection::PaperCorrection(const rom::Network& network, PaperOptions options, const StepperFactory& make_stepper)
    : impl_(std::make_unique<Impl>(network, std::move(options), make_stepper)) {}
PaperCorrection::~PaperCorrection() = default;
PaperCorrection::PaperCorrection(PaperCorrection&&) noexcept = default;
PaperCorrection& PaperCorrection::operator=(PaperCorrection&&) noexcept = default;

void PaperCorrection::reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating) {
  impl_->reset(time_s, nodes_K, operating);
}

PaperStep PaperCorrection::step(const PaperSample& sample, double advance_s) { return impl_->step(sample, advance_s); }

void PaperCorrection::stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating,
                               double advance_s) {
  impl_->stand_by(time_s, nodes_K, operating, advance_s);
}

const rom::CorrectionFactors& PaperCorrection::factors() const { return impl_->factors; }
const Eigen::VectorXd& PaperCorrection::rescaled_nodes_K() const { return impl_->rescaled_K; }
int PaperCorrection::groups() const { return static_cast<int>(impl_->groups.size()); }
Freeze PaperCorrection::freeze(int group) const { return impl_->groups.at(static_cast<std::size_t>(group)).freeze; }
double PaperCorrection::ratio(int group) const { return impl_->groups.at(static_cast<std::size_t>(group)).ratio; }
double PaperCorrection::base_rise_K(int group) const {
  return impl_->groups.at(static_cast<std::size_t>(group)).rise_K;
}

}  // namespace spindle_twin::correction

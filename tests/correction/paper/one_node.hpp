#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <string>

#include "correction/paper/paper_correction.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/stepper.hpp"
#include "rom/network.hpp"
#include "tests/support/no_guards.hpp"

/// Independent heated nodes, each against one ambient, whose answer is known in closed form.
namespace spindle_twin::correction::test {

constexpr double ambient_K = 300.15;

/// `nodes` bodies of tau_s each, 1 W/K to ambient, one source of steady_rise_K watts on each (so that is its steady
/// rise) and `sensors_per_node` key points on each.
inline rom::Network node_network(double tau_s, double steady_rise_K, int nodes = 1, int sensors_per_node = 3) {
  rom::Network network;
  network.spindle = "independent nodes";
  network.capacity_J_per_K = tau_s * Eigen::MatrixXd::Identity(nodes, nodes);
  network.conduction_W_per_K = Eigen::MatrixXd::Zero(nodes, nodes);
  network.source_distribution = Eigen::MatrixXd::Identity(nodes, nodes);
  rom::Boundaries& boundaries = network.boundaries;
  boundaries.reference_speed_rpm = 6000.0;
  boundaries.reference_temperature_K = ambient_K;
  boundaries.environments = {{"ambient", rom::EnvironmentKind::ambient}};
  boundaries.operating = {6000.0, 1.0, Eigen::VectorXd::Constant(1, ambient_K)};
  for (int n = 0; n < nodes; ++n) {
    const Eigen::VectorXd row = Eigen::VectorXd::Unit(nodes, n);
    const std::string part = "body" + std::to_string(n);
    network.nodes.push_back({part, part, 0.0, 0.0});
    network.parts.push_back({part, row, row.transpose()});
    for (int k = 0; k < sensors_per_node; ++k) {
      network.key_points.push_back({part + " sensor" + std::to_string(k), part, 0.0, 0.0, row});
    }
    boundaries.sources.push_back({"heat" + std::to_string(n), steady_rise_K, {}});
    rom::Conductance film;
    film.name = "film" + std::to_string(n);
    film.kind = rom::ConductanceKind::air_film;
    film.nominal_W_per_m2K = 1.0;
    film.area_m2 = 1.0;
    film.environment = 0;
    film.part_a = n;
    boundaries.conductances.push_back(film);
    network.factors_m.push_back(row);
  }
  return network;
}

/// T' = T_inf + q/G + (T - T_inf - q/G) exp(-t/tau), exact.
class NodeStepper : public rom::Stepper {
 public:
  explicit NodeStepper(double tau_s, int nodes = 1)
      : tau_s_(tau_s), temperatures_K_(Eigen::VectorXd::Constant(nodes, ambient_K)) {}
  void set_temperatures(const Eigen::VectorXd& temperatures_K) override { temperatures_K_ = temperatures_K; }
  rom::StepStatus advance(double period_s, const rom::BoundaryValues& values) override {
    if (fail) return rom::StepStatus::integrator_failed;
    for (Eigen::Index n = 0; n < temperatures_K_.size(); ++n) {
      const double conductance = values.conductance_W_per_m2K[n];
      const double final_K = values.environment_K[0] + values.heat_W[n] / conductance;
      temperatures_K_[n] = final_K + (temperatures_K_[n] - final_K) * std::exp(-period_s * conductance / tau_s_);
    }
    return rom::StepStatus::ok;
  }
  const Eigen::VectorXd& temperatures_K() const override { return temperatures_K_; }
  inline static bool fail = false;

 private:
  double tau_s_;
  Eigen::VectorXd temperatures_K_;
};

/// Plant and twin of the same kind, corrected in closed loop; the twin assumes `excess` times the true heat.
struct Loop {
  Loop(double tau_s, double excess, const PaperOptions& options, int nodes = 1, int sensors_per_node = 3)
      : network(node_network(tau_s, excess * true_rise_K, nodes, sensors_per_node)),
        plant(tau_s, nodes),
        twin(tau_s, nodes),
        correction(network, options, [=] { return std::make_unique<NodeStepper>(tau_s, nodes); }),
        operating(network.boundaries.operating),
        offset_K(Eigen::VectorXd::Zero(nodes * sensors_per_node)),
        valid(Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(nodes * sensors_per_node, true)),
        true_heat(Eigen::VectorXd::Constant(nodes, 1.0 / excess)),
        values(rom::make_boundary_values(network.boundaries)),
        factors(rom::no_correction(network.boundaries)) {}

  static constexpr double true_rise_K = 2.29;

  Eigen::VectorXd read(const Eigen::VectorXd& nodes_K) const {
    Eigen::VectorXd reading_K(network.key_points.size());
    for (Eigen::Index k = 0; k < reading_K.size(); ++k) {
      reading_K[k] = network.key_points[static_cast<std::size_t>(k)].row.dot(nodes_K);
    }
    return reading_K;
  }

  /// One cycle at time_s, then everything moves on by advance_s.
  PaperStep cycle(double advance_s) {
    const Eigen::VectorXd measured_K = read(plant.temperatures_K()) + offset_K;
    const Eigen::VectorXd predicted_K = read(twin.temperatures_K());
    const PaperStep result =
        correction.step({time_s, measured_K, valid, predicted_K, twin.temperatures_K(), operating}, advance_s);
    if (result.state_rescaled) twin.set_temperatures(correction.rescaled_nodes_K());
    rom::evaluate_boundaries(network.boundaries, operating, correction.factors(), values);
    twin.advance(advance_s, values);
    factors.heat = true_heat;
    rom::evaluate_boundaries(network.boundaries, operating, factors, values);
    plant.advance(advance_s, values);
    time_s += advance_s;
    return result;
  }

  void run_until(double end_s, double advance_s) {
    while (time_s < end_s - 1e-9) cycle(advance_s);
  }

  /// Heat of the twin over the true heat.
  double heat_ratio(int source = 0) const { return correction.factors().heat[source] / true_heat[source]; }
  double rise_error() const {
    return (twin.temperatures_K()[0] - ambient_K) / (plant.temperatures_K()[0] - ambient_K) - 1.0;
  }

  rom::Network network;
  NodeStepper plant;
  NodeStepper twin;
  PaperCorrection correction;
  rom::OperatingState operating;
  Eigen::VectorXd offset_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
  Eigen::VectorXd true_heat;
  rom::BoundaryValues values;
  rom::CorrectionFactors factors;
  double time_s = 0.0;
};

/// The published law: one reading per period, no guard, no rescaled state, no joints.
inline PaperOptions published_law() {
  PaperOptions options;
  options.window_s = 0.0;
  options.relaxation = 1.0;
  options.state_rescale = false;
  options.joint_law = false;
  options.guards = tests::no_guards();
  return options;
}

}  // namespace spindle_twin::correction::test

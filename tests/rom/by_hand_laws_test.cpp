#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <sstream>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/laws/law_fields.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/operating_values.hpp"

namespace spindle_twin::rom::tests {
namespace by_hand_laws_test {

const std::string motor_spindle_laws = SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle_laws.toml";

std::string text_of_example() {
  std::ifstream file(motor_spindle_laws);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Law of a source or conductance of the example at one state, through nothing of the integrator.
double law_value(const Network& network, const BoundLaw& bound, const Eigen::VectorXd& temperatures_K,
                 const LawDrive& drive, const Eigen::VectorXd& environment_K) {
  LawState state = nominal_state(bound, drive, environment_K);
  if (bound.first.part >= 0) {
    state[LawInput::first_K] = network.parts[static_cast<std::size_t>(bound.first.part)].mean_row.dot(temperatures_K);
  }
  if (bound.second.part >= 0) {
    state[LawInput::second_K] = network.parts[static_cast<std::size_t>(bound.second.part)].mean_row.dot(temperatures_K);
  }
  if (bound.displacement >= 0) {
    const Eigen::VectorXd& row = network.deformations[static_cast<std::size_t>(bound.displacement)].row_m_per_K;
    const Eigen::VectorXd rise_K = temperatures_K.array() - network.boundaries.reference_temperature_K;
    state[LawInput::displacement_m] = bound.displacement_sign * row.dot(rise_K);
  }
  return evaluate(bound.law, state).value;
}

/// dT/dt of the example straight from its description: node by node, the water marched through its two segments.
Eigen::VectorXd rate_K_per_s(const Network& network, const Eigen::VectorXd& temperatures_K) {
  const Boundaries& boundaries = network.boundaries;
  LawDrive drive;
  set_machine(boundaries.operating, drive);
  const Eigen::VectorXd& environment_K = boundaries.operating.environment_K;
  Eigen::VectorXd heat_W = -network.conduction_W_per_K * temperatures_K;
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    heat_W += law_value(network, *boundaries.sources[i].physics, temperatures_K, drive, environment_K) *
              network.source_distribution.col(static_cast<Eigen::Index>(i));
  }
  const double flow_W_per_K = boundaries.operating.flow_kg_per_s[0] * boundaries.circuits[0].heat_capacity_J_per_kgK;
  double water_K = environment_K[boundaries.circuits[0].environment];
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const Conductance& item = boundaries.conductances[j];
    double film = item.nominal_W_per_m2K;
    if (item.physics) film = law_value(network, *item.physics, temperatures_K, drive, environment_K);
    const bool segment = item.physics && is_channel(item.physics->law);
    if (segment) film = flow_W_per_K * (1.0 - std::exp(-film * item.area_m2 / flow_W_per_K)) / item.area_m2;
    const Eigen::MatrixXd& factor = network.factors_m[j];
    Eigen::VectorXd jump_K = factor.transpose() * temperatures_K;
    if (item.environment >= 0) {
      jump_K -= (segment ? water_K : environment_K[item.environment]) * factor.colwise().sum().transpose();
    }
    const Eigen::VectorXd taken_W = film * (factor * jump_K);
    heat_W -= taken_W;
    if (segment) water_K += taken_W.sum() / flow_W_per_K;
  }
  return heat_W.cwiseQuotient(network.capacity_J_per_K.diagonal());
}

TEST(ByHandLaws, example_meets_an_independent_integration) {
  const Network network = read_by_hand(motor_spindle_laws);
  ASSERT_TRUE(has_physics(network.boundaries));
  BoundaryValues values = operating_values(network);
  const auto shared = std::make_shared<const NetworkOperator>(network);
  CvodeStepper stepper(shared);
  Eigen::VectorXd temperatures_K = Eigen::VectorXd::Constant(shared->nodes(), 293.15);
  stepper.set_temperatures(temperatures_K);
  constexpr double h_s = 0.2;
  double largest_K = 0.0;
  for (int second = 1; second <= 1800; ++second) {
    ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    for (int k = 0; k < 5; ++k) {
      const auto f = [&](const Eigen::VectorXd& at_K) { return rate_K_per_s(network, at_K); };
      const Eigen::VectorXd k1 = f(temperatures_K), k2 = f(temperatures_K + 0.5 * h_s * k1),
                            k3 = f(temperatures_K + 0.5 * h_s * k2), k4 = f(temperatures_K + h_s * k3);
      temperatures_K += h_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    largest_K = std::max(largest_K, (stepper.temperatures_K() - temperatures_K).cwiseAbs().maxCoeff());
  }
  std::printf("largest difference over 1800 s: %.2e K at rises up to %.1f K\n", largest_K,
              temperatures_K.maxCoeff() - 293.15);
  EXPECT_LT(largest_K, 1e-3);
  EXPECT_GT(temperatures_K.maxCoeff() - 293.15, 10.0);
  // The steady state closes: what the laws give is what air and water take.
  const Eigen::VectorXd steady_K = steady_temperatures_K(shared, values);
  EXPECT_LT(rate_K_per_s(network, steady_K).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(steady_K.maxCoeff(), 473.15);
}

TEST(ByHandLaws, an_output_that_closes_a_bearing_counts_up_and_one_that_opens_it_down) {
  const auto sign_with = [](const std::string& key) {
    std::string text = text_of_example();
    const std::string closing = "closing = \"rings_nearer\"";
    text.replace(text.find(closing), closing.size(), key + " = \"rings_nearer\"");
    for (const HeatSource& source : parse_by_hand(text, "laws.toml").boundaries.sources) {
      if (source.physics && source.physics->displacement >= 0) return source.physics->displacement_sign;
    }
    return 0.0;
  };
  EXPECT_EQ(sign_with("closing"), 1.0);
  EXPECT_EQ(sign_with("opening"), -1.0);
}

TEST(ByHandLaws, heats_go_where_physics_lets_them) {
  const Network network = read_by_hand(motor_spindle_laws);
  const NetworkOperator coordinates(network);
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  const auto at = [&](const OperatingState& state, double degC) {
    rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
    coordinates.laws().at_temperatures(Eigen::VectorXd::Constant(coordinates.nodes(), degC + 273.15), values);
    return values.heat_W;
  };
  OperatingState state = network.boundaries.operating;
  const Eigen::VectorXd cold_W = at(state, 20.0), warm_W = at(state, 60.0);
  EXPECT_LT(warm_W[0], 0.8 * cold_W[0]);
  EXPECT_NEAR(warm_W[2] / cold_W[2], 1.0 + 0.00393 * 40.0, 0.05);
  EXPECT_EQ(warm_W[3], cold_W[3]);
  state.current_A = 8.0;
  EXPECT_NEAR(at(state, 20.0)[2] / cold_W[2], 0.25, 1e-12) << "measured current, half the rated one";
  state.speed_rpm = 0.0;
  EXPECT_EQ(at(state, 20.0)[0], 0.0);
}

TEST(ByHandLaws, bad_laws_end_in_one_error_with_line_and_key) {
  struct Case {
    std::string from, to, says;
  };
  const std::vector<Case> cases = {
      {"kind = \"copper_loss\"", "kind = \"copper_lose\"", "heat.copper.law.kind"},
      {"kind = \"copper_loss\"", "kind = \"contact\"", "bearing_friction, windage, copper_loss"},
      {"resistance_20_ohm = 0.22", "resistance_20_ohm = 0.0", "heat.copper.law.resistance_20_ohm"},
      {"resistance_20_ohm = 0.22, ", "", "heat.copper.law.resistance_20_ohm"},
      {"ac_ratio = 1.15", "ac_raito = 1.15", "ac_raito"},
      {"winding = \"winding\", ", "", "heat.copper.law.winding: missing: must name a part or surrounding"},
      {"winding = \"winding\", ", "winding = \"windings\", ", "there is no part or surrounding \"windings\""},
      {"winding_degC = 70.0, ", "", "heat.copper.law.winding_degC"},
      {"closing = \"rings_nearer\"", "closing = \"ring\"", "there is no deformation output \"ring\""},
      {"closing = \"rings_nearer\"", "closing = \"nose\", opening = \"nose\"", "cannot stand beside closing"},
      {"viscosities = [[40.0, 32.0], [100.0, 5.4]], closing", "viscosities = [[40.0, 5.4], [100.0, 32.0]], closing",
       "the colder and thicker one"},
      {"viscosities = [[40.0, 32.0], [100.0, 5.4]], closing", "viscosities = [[40.0, 32.0], [100.0, 32.0]], closing",
       "the colder and thicker one"},
      {"viscosities = [[40.0, 32.0], [100.0, 5.4]], closing", "viscosities = [[40.0, 32.0], [100.0, 0.3]], closing",
       "both above 0.3 mm2/s"},
      {"node = \"winding\"\nlaw", "node = \"winding\"\nheat_W = 3.0\nlaw",
       "heat.copper.heat_W: cannot stand beside law"},
      {"joint_radius_mm = 22.5", "joint_radius_mm = 27.0", "must lie between bore and outer radius"},
      {"rings_nearer\" }", "rings_nearer\", mode = \"guessed\" }", "standard, as_published, as_printed"},
      {"kind = \"channel\"", "kind = \"rotating_cylinder\"", "coolant_circuit.jacket.law.kind"}};
  const std::string good = text_of_example();
  EXPECT_NO_THROW(parse_by_hand(good, "laws.toml"));
  for (const Case& item : cases) {
    std::string text = good;
    const std::size_t at = text.find(item.from);
    ASSERT_NE(at, std::string::npos) << item.from;
    text.replace(at, item.from.size(), item.to);
    try {
      parse_by_hand(text, "laws.toml");
      ADD_FAILURE() << item.to << " was taken";
    } catch (const InputError& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find(item.says), std::string::npos) << item.to << ": " << said;
      EXPECT_TRUE(said.starts_with("laws.toml:")) << said;
    }
  }
}

}  // namespace by_hand_laws_test
}  // namespace spindle_twin::rom::tests

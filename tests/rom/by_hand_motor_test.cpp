#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/by_hand_texts.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace by_hand_motor_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A winding in a housing in a room of 20 degC, whatever is between the two nodes.
std::string motor(const std::string& between, const std::string& of_heat = "measured = true\n") {
  return in_a_room("motor", R"([[node]]
name = "winding"
part = "winding"
capacity_J_per_K = 200.0
[[node]]
name = "housing"
part = "housing"
capacity_J_per_K = 900.0
)" + between +
                                R"([[film]]
name = "air"
surrounding = "room"
node = "housing"
area_mm2 = 500000.0
coefficient_W_per_m2K = 10.0
[[heat]]
name = "loss"
heat_W = 30.0
node = "winding"
speed_law = { constant = 0.0, speed_terms = [[1.0, 1.0]] }
)" + of_heat + "[[key_point]]\nname = \"winding\"\nnode = \"winding\"\n");
}

const std::string conduction = "[[conduction]]\nbetween = [\"winding\", \"housing\"]\nconductance_W_per_K = 3.0\n";
const std::string correctable = conduction + "correctable = true\nname = \"slots\"\n";

std::string refusal_of_motor(const std::string& text) {
  return spindle_twin::tests::refusal_of([&] { parse_by_hand(text, "motor.toml"); });
}

BoundaryValues values_of(const Network& network, const OperatingState& state, double conductance_factor = 1.0) {
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  factors.conductance[0] = conductance_factor;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::evaluate_boundaries(network.boundaries, state, factors, values);
  return values;
}

Eigen::VectorXd steady_K(const Network& network, const BoundaryValues& values) {
  return steady_temperatures_K(std::make_shared<const NetworkOperator>(network), values);
}

/// All of the heat goes through 3 W/K, however they are written, and then through 5 W/K.
TEST(ByHandMotor, watts_per_kelvin_are_the_same_however_they_are_written) {
  const std::string pair = "between = [\"winding\", \"housing\"]\n";
  const std::string faces =
      "faces = [{ between = [\"winding\", \"housing\"] }, { between = [\"winding\", \"housing\"] }]\n";
  for (const std::string& between :
       {conduction, correctable, "[[contact]]\nname = \"slots\"\nconductance_W_per_K = 3.0\n" + pair,
        "[[contact]]\nname = \"slots\"\nconductance_W_per_K = 1.5\n" + faces,
        "[[contact]]\nname = \"slots\"\nconductance_W_per_m2K = 300.0\narea_mm2 = 10000.0\n" + pair}) {
    const Network network = parse_by_hand(motor(between), "motor.toml");
    const Eigen::VectorXd kelvin = steady_K(network, values_of(network, network.boundaries.operating));
    EXPECT_NEAR(kelvin[1], 293.15 + 30.0 / 5.0, 1e-9) << between;
    EXPECT_NEAR(kelvin[0], kelvin[1] + 30.0 / 3.0, 1e-9) << between;
  }
}

TEST(ByHandMotor, a_correctable_conduction_is_a_contact_that_a_factor_moves) {
  const Network network = parse_by_hand(motor(correctable), "motor.toml");
  ASSERT_EQ(network.boundaries.conductances.size(), 2u);
  const Conductance& slots = network.boundaries.conductances[0];
  EXPECT_EQ(slots.name, "slots");
  EXPECT_EQ(slots.kind, ConductanceKind::contact);
  EXPECT_EQ(slots.nominal_W_per_m2K, 3.0);
  EXPECT_EQ(slots.area_m2, 1.0);
  EXPECT_EQ(network.parts[static_cast<std::size_t>(slots.part_a)].name, "winding");
  EXPECT_EQ(network.conduction_W_per_K.norm(), 0.0);
  const Eigen::VectorXd kelvin = steady_K(network, values_of(network, network.boundaries.operating, 2.0));
  EXPECT_NEAR(kelvin[0] - kelvin[1], 30.0 / 6.0, 1e-9);
}

TEST(ByHandMotor, a_measured_heat_is_what_was_read_and_its_law_where_nothing_was) {
  const Network network = parse_by_hand(motor(conduction), "motor.toml");
  EXPECT_EQ(measured_heats(network.boundaries), (std::vector<std::size_t>{0}));
  OperatingState state = network.boundaries.operating;
  ASSERT_EQ(state.heat_W.size(), 1);
  EXPECT_TRUE(std::isnan(state.heat_W[0]));
  CorrectionFactors factors = rom::no_correction(network.boundaries);
  factors.heat[0] = 1.1;
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  const auto heat_W = [&](double speed_rpm, const Eigen::VectorXd& read_W) {
    state.speed_rpm = speed_rpm;
    state.heat_W = read_W;
    rom::evaluate_boundaries(network.boundaries, state, factors, values);
    return values.heat_W[0];
  };
  EXPECT_NEAR(heat_W(500.0, Eigen::VectorXd::Constant(1, nan)), 1.1 * 15.0, 1e-12);
  EXPECT_NEAR(heat_W(500.0, Eigen::VectorXd(0)), 1.1 * 15.0, 1e-12);
  EXPECT_NEAR(heat_W(500.0, Eigen::VectorXd::Constant(1, 44.0)), 1.1 * 44.0, 1e-12);
  EXPECT_NEAR(heat_W(0.0, Eigen::VectorXd::Constant(1, -2.0)), 1.1 * -2.0, 1e-12);
}

/// What the measured watts bring in is what the room takes and the nodes store.
TEST(ByHandMotor, heat_balance_closes_over_a_schedule_of_watts) {
  const Network network = parse_by_hand(motor(correctable), "motor.toml");
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string path =
      folder.write("day.csv", "time_s,speed_rpm,load,heat.loss_W\n0,0,0,80\n400,0,0,10\n900,0,0,0\n1500,0,0,0\n");
  const rom::Schedule schedule = rom::read_schedule(path, network.boundaries);
  OperatingState state = network.boundaries.operating;
  CvodeStepper stepper(std::make_shared<const NetworkOperator>(network));
  const Eigen::VectorXd start_K = Eigen::VectorXd::Constant(2, 293.15);
  stepper.set_temperatures(start_K);
  double given_J = 0.0, taken_J = 0.0;
  for (int second = 0; second < 1500; ++second) {
    rom::state_at(schedule, second, state);
    const BoundaryValues values = values_of(network, state);
    given_J += values.heat_W[0];
    const double before_K = stepper.temperatures_K()[1];
    ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    taken_J += 5.0 * (0.5 * (before_K + stepper.temperatures_K()[1]) - 293.15);
  }
  EXPECT_NEAR(given_J, 80.0 * 400.0 + 10.0 * 500.0, 1e-9);
  const double stored_J = network.capacity_J_per_K.diagonal().dot(stepper.temperatures_K() - start_K);
  EXPECT_NEAR(stored_J + taken_J, given_J, 1e-4 * given_J);
}

TEST(ByHandMotor, a_network_without_deformations_keeps_its_mark_and_its_measured_heat_in_a_file) {
  const Network network = read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/two_node.toml");
  EXPECT_TRUE(network.deformations.empty());
  const RomFile file = decode_rom_file(encode_network(network), "x.rom");
  EXPECT_EQ(file.schema_version, 6u);
  EXPECT_EQ(encode_network(file.network), encode_network(network));
  ASSERT_EQ(file.network.boundaries.sources.size(), 1u);
  EXPECT_TRUE(file.network.boundaries.sources[0].measured);
  EXPECT_EQ(file.network.boundaries.operating.heat_W.size(), 1);
  const Eigen::VectorXd kelvin = steady_K(network, values_of(network, network.boundaries.operating));
  EXPECT_NEAR(kelvin[1], 293.15 + 150.0 / 5.0, 1e-9) << "as the example says";
  EXPECT_NEAR(kelvin[0] - kelvin[1], 0.8 * 150.0 / 6.0, 1e-9);

  Network built = network;
  built.hand_written = false;
  try {
    encode_network(built);
    check_network(built, "x.rom");
    FAIL() << "a network of an FE model needs a nose";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("deformations"), std::string::npos);
  }
}

TEST(ByHandMotor, every_mistake_is_one_error_with_line_and_field) {
  const std::string pair = "between = [\"winding\", \"housing\"]\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {motor(conduction + "correctable = true\n"), "conduction[1].name: this key is required"},
      {motor(conduction + "name = \"slots\"\n"), "conduction[1].name: is only of use"},
      {motor(correctable + conduction), "these two nodes have a conduction already"},
      {motor("[[contact]]\nname = \"s\"\nconductance_W_per_K = 3.0\narea_mm2 = 1.0\n" + pair),
       "motor.toml:20: contact.s.area_mm2: cannot stand beside conductance_W_per_K"},
      {motor("[[contact]]\nname = \"s\"\nconductance_W_per_K = 3.0\nconductance_W_per_m2K = 1.0\n" + pair),
       "contact.s.conductance_W_per_m2K: cannot stand beside conductance_W_per_K"},
      {motor("[[contact]]\nname = \"s\"\nconductance_W_per_K = 0.0\n" + pair),
       "contact.s.conductance_W_per_K: must be"},
      {motor("[[contact]]\nname = \"air\"\nconductance_W_per_K = 1.0\n" + pair), "the name \"air\" is taken"},
      {motor(conduction, "measured = 3\n"), "heat.loss.measured: must be"},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_NE(refusal_of_motor(text).find(expected), std::string::npos) << expected << "\n" << refusal_of_motor(text);
  }
}

}  // namespace by_hand_motor_test
}  // namespace spindle_twin::rom::tests

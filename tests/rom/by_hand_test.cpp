#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "tests/rom/by_hand_texts.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace by_hand_test {

using spindle_twin::tests::refusal_of;

/// Two nodes a and b, an exchange of 2 W/K between them, 1 W/K from b to a room of 20 degC, 30 W into a.
const std::string two_nodes = in_a_room("two", R"([[node]]
name = "a"
part = "body"
capacity_J_per_K = 100.0
at = [1.0, 2.0]
[[node]]
name = "b"
part = "body"
mass_kg = 0.5
heat_capacity_J_per_kgK = 400.0
[[conduction]]
between = ["a", "b"]
conductance_W_per_K = 2.0
[[film]]
name = "to_room"
surrounding = "room"
node = "b"
area_mm2 = 50000.0
coefficient_W_per_m2K = 20.0
[[heat]]
name = "heater"
heat_W = 30.0
node = "a"
[[key_point]]
name = "middle"
weights = { a = 0.25, b = 0.75 }
[[deformation]]
name = "nose"
um_per_K = { a = 1.5, b = -0.5 }
)");

std::string with(const std::string& what, const std::string& instead) {
  return spindle_twin::tests::with(two_nodes, what, instead);
}

std::string error_of(const std::string& text) {
  return refusal_of([&] { parse_by_hand(text, "net.toml"); });
}

/// C_a x' = −2 x + 2 y + 30, C_b y' = 2 x − 3 y, from rest, by the eigenvalues of the 2 x 2 system.
TEST(ByHand, two_nodes_follow_their_two_exponentials) {
  const Network network = parse_by_hand(two_nodes, "net.toml");
  const double ca = 100.0, cb = 200.0;
  const double trace = -2.0 / ca - 3.0 / cb, determinant = (2.0 * 3.0 - 2.0 * 2.0) / (ca * cb);
  const double root = std::sqrt(trace * trace / 4.0 - determinant);
  const double fast = trace / 2.0 - root, slow = trace / 2.0 + root;
  const double steady_a = 45.0, steady_b = 30.0;
  // x − x∞ = p e^(fast t) + q e^(slow t), y − y∞ = p k_fast e^(fast t) + q k_slow e^(slow t), k = (ca λ + 2) / 2.
  const double k_fast = (ca * fast + 2.0) / 2.0, k_slow = (ca * slow + 2.0) / 2.0;
  const double q = (-steady_b + steady_a * k_fast) / (k_slow - k_fast), p = -steady_a - q;

  const BoundaryValues values = operating_values(network);
  CvodeStepper stepper(std::make_shared<const NetworkOperator>(network));
  stepper.set_temperatures(Eigen::VectorXd::Constant(2, 293.15));
  for (int second = 1; second <= 600; ++second) {
    ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    if (second % 60 != 0) continue;
    const double t = second;
    const double rise_a = steady_a + p * std::exp(fast * t) + q * std::exp(slow * t);
    const double rise_b = steady_b + p * k_fast * std::exp(fast * t) + q * k_slow * std::exp(slow * t);
    EXPECT_NEAR(stepper.temperatures_K()[0] - 293.15, rise_a, 2e-3) << t;
    EXPECT_NEAR(stepper.temperatures_K()[1] - 293.15, rise_b, 2e-3) << t;
  }
}

TEST(ByHand, steady_state_and_outputs_by_hand) {
  const Network network = parse_by_hand(two_nodes, "net.toml");
  const BoundaryValues values = operating_values(network);
  const auto channels = std::make_shared<const NetworkOperator>(network);
  const Eigen::VectorXd steady_K = steady_temperatures_K(channels, values);
  EXPECT_NEAR(steady_K[0], 293.15 + 45.0, 1e-9);
  EXPECT_NEAR(steady_K[1], 293.15 + 30.0, 1e-9);
  NetworkOutputs outputs = make_network_outputs(network);
  evaluate_outputs(network, steady_K, outputs);
  EXPECT_NEAR(outputs.key_points_K[0], 293.15 + 0.25 * 45.0 + 0.75 * 30.0, 1e-9);
  EXPECT_NEAR(outputs.part_mean_K[0], 293.15 + (100.0 * 45.0 + 200.0 * 30.0) / 300.0, 1e-9);
  EXPECT_NEAR(outputs.part_maximum_K[0], 293.15 + 45.0, 1e-9);
  EXPECT_NEAR(outputs.part_minimum_K[0], 293.15 + 30.0, 1e-9);
  EXPECT_NEAR(outputs.deformations_m[0], 1e-6 * (1.5 * 45.0 - 0.5 * 30.0), 1e-15);
}

const std::string motor_spindle = SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle.toml";

/// What is stored plus what has left is what was put in, over an hour of the example at its operating state.
TEST(ByHand, heat_is_conserved_over_an_hour) {
  const Network network = read_by_hand(motor_spindle);
  const BoundaryValues values = operating_values(network);
  const Eigen::Index n = network.capacity_J_per_K.rows();
  const auto channels = std::make_shared<const NetworkOperator>(network);
  Eigen::MatrixXd film_W_per_K = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    if (network.boundaries.conductances[j].environment < 0) continue;
    film_W_per_K += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * network.factors_m[j] *
                    network.factors_m[j].transpose();
  }
  ExactStepper stepper(channels);
  stepper.set_temperatures(Eigen::VectorXd::Constant(n, 293.15));
  const double put_in_W = values.heat_W.sum();
  EXPECT_NEAR(put_in_W, 95.0 + 380.0, 1e-9);
  // ∫T dt over an hour follows from the state at its end: C (T − T₀) = −K ∫(T − T_steady) dt.
  const Eigen::VectorXd steady_K = steady_temperatures_K(channels, values);
  Eigen::MatrixXd all_W_per_K = network.conduction_W_per_K;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    all_W_per_K += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * network.factors_m[j] *
                   network.factors_m[j].transpose();
  }
  const Eigen::VectorXd start_K = stepper.temperatures_K();
  ASSERT_EQ(stepper.advance(3600.0, values), StepStatus::ok);
  const Eigen::VectorXd change_K = stepper.temperatures_K() - start_K;
  const Eigen::VectorXd integral_Ks =
      3600.0 * (steady_K - start_K) - all_W_per_K.llt().solve(network.capacity_J_per_K * change_K);
  const double stored_J = (network.capacity_J_per_K * change_K).sum();
  const double left_J = (film_W_per_K * integral_Ks).sum();
  EXPECT_NEAR(stored_J + left_J, 3600.0 * put_in_W, 1e-9 * 3600.0 * put_in_W);
  // In the end all heat leaves, and no part is colder than what cools it.
  EXPECT_NEAR((film_W_per_K * (steady_K - start_K)).sum(), put_in_W, 1e-9 * put_in_W);
  EXPECT_GT(steady_K.minCoeff(), 293.15);
}

TEST(ByHand, the_example_is_a_network_like_any_other) {
  const Network network = read_by_hand(motor_spindle);
  const RomFile file = decode_rom_file(encode_network(network), "x.rom");
  EXPECT_EQ(encode_network(file.network), encode_network(network));
  EXPECT_TRUE(file.network.hand_written);
  EXPECT_EQ(network.nodes.size(), 8u);
  EXPECT_EQ(network.certificate.cases, 0u);
  EXPECT_EQ(network.description_hash.size(), 64u);
  ASSERT_EQ(network.parts.size(), 4u);
  EXPECT_EQ(network.parts[2].name, "housing");
  EXPECT_EQ(network.nodes[1].part, "shaft");
  EXPECT_DOUBLE_EQ(network.nodes[1].z_m, 0.150);
  EXPECT_DOUBLE_EQ(network.capacity_J_per_K(1, 1), 3.0 * 460.0);
  const Conductance& seats = network.boundaries.conductances[0];
  EXPECT_EQ(seats.name, "front_bearing_seats");
  EXPECT_NEAR(seats.area_m2, 13800e-6, 1e-15);
  EXPECT_EQ(seats.part_a, -1) << "its faces begin at two different parts";
  const Conductance& stator_seat = network.boundaries.conductances[2];
  EXPECT_EQ(stator_seat.part_a, 3);
  EXPECT_EQ(stator_seat.part_b, 2);
  EXPECT_EQ(network.boundaries.conductances[3].kind, ConductanceKind::gap_film);
  EXPECT_EQ(network.boundaries.conductances[3].law.speed_terms[0].exponent, 0.8);
}

TEST(ByHand, a_coolant_channel_and_an_air_node_are_what_they_are_in_every_network) {
  std::string text = with("temperatures_degC = { room = 20.0 }", "temperatures_degC = { room = 20.0, water = 15.0 }");
  text += R"(
[[surrounding]]
name = "water"
kind = "coolant"
[[node]]
name = "cavity"
capacity_J_per_K = 0.4
[[gap_film]]
name = "cavity_air"
between = ["b", "cavity"]
area_mm2 = 1000.0
coefficient_W_per_m2K = 25.0
[[contact]]
name = "seat"
between = ["a", "b"]
area_mm2 = 100.0
conductance_W_per_m2K = 5000.0
[[coolant_circuit]]
name = "helix"
inlet = "water"
flow_kg_per_s = 0.002
heat_capacity_J_per_kgK = 4180.0
coefficient_W_per_m2K = 800.0
segments = [{ name = "first", node = "a", area_mm2 = 900.0 }, { name = "second", node = "b", area_mm2 = 900.0 }]
[[contact_pressure]]
name = "seat_pressure"
assembly_pressure_Pa = 2e6
Pa_per_K = { a = 1e4, b = -1e4 }
)";
  const Network network = parse_by_hand(text, "net.toml");
  EXPECT_EQ(network.boundaries.conductances[1].kind, ConductanceKind::air_film);
  ASSERT_EQ(network.boundaries.circuits.size(), 1u);
  EXPECT_EQ(network.boundaries.circuits[0].segments, (std::vector<int>{3, 4}));
  EXPECT_EQ(network.contact_pressures[0].row_Pa_per_K[1], -1e4);
  const BoundaryValues values = operating_values(network);
  const auto channels = std::make_shared<const NetworkOperator>(network);
  const Eigen::VectorXd steady_K = steady_temperatures_K(channels, values);
  const double to_room_W = 1.0 * (steady_K[1] - 293.15);
  EXPECT_NEAR(coolant_outlets(*channels, values, steady_K).heat_W[0] + to_room_W, 30.0, 1e-9);
  EXPECT_NEAR(steady_K[2], steady_K[1], 1e-9) << "the air takes the temperature of the only wall it has";
}

TEST(ByHand, every_mistake_is_one_error_with_file_line_and_field) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {with("capacity_J_per_K = 100.0", "capacity_J_per_K = -1.0"), "net.toml:12: node.a.capacity_J_per_K: must be"},
      {with("capacity_J_per_K = 100.0\n", ""), "net.toml:9: node.a.capacity_J_per_K: a node needs either"},
      {with("mass_kg = 0.5\n", "mass_kg = 0.5\ncapacity_J_per_K = 1.0\n"),
       "node.b.capacity_J_per_K: a node needs either"},
      {with("name = \"b\"", "name = \"a\""),
       "net.toml:15: node.a.name: the name \"a\" is taken by the node of line 10"},
      {with("between = [\"a\", \"b\"]", "between = [\"a\", \"c\"]"),
       "net.toml:20: conduction[1].between: there is no node \"c\"; there are: a, b"},
      {with("between = [\"a\", \"b\"]", "between = [\"a\", \"a\"]"), "conduction[1].between: \"a\" is listed twice"},
      {with("between = [\"a\", \"b\"]", "between = [\"a\"]"), "must be the names of two different nodes"},
      {with("conductance_W_per_K = 2.0", "conductance_W_per_K = 0.0"), "conduction[1].conductance_W_per_K: must be"},
      {with("conductance_W_per_K = 2.0", "conductance_W_per_K = nan"), "conduction[1].conductance_W_per_K: must be"},
      {with("[[film]]", "[[conduction]]\nbetween = [\"b\", \"a\"]\nconductance_W_per_K = 2.0\n[[film]]"),
       "net.toml:23: conduction[2].between: these two nodes have a conduction already"},
      {with("surrounding = \"room\"", "surrounding = \"hall\""), "film.to_room.surrounding: there is no surrounding"},
      {with("area_mm2 = 50000.0", "area_mm2 = 0.0"), "film.to_room.area_mm2: must be"},
      {with("area_mm2 = 50000.0", "faces = [{ node = \"b\", area_mm2 = 1.0 }]"),
       "film.to_room.node: stands in each of the faces"},
      {with("{ a = 0.25, b = 0.75 }", "{ a = 0.25, b = 0.7 }"),
       "key_point.middle.weights: the weights must add up to 1"},
      {with("node = \"a\"\n", ""), "heat.heater.node: either this or weights is needed"},
      {with("um_per_K = { a = 1.5, b = -0.5 }", "um_per_K = {}"), "deformation.nose.um_per_K: must give at least one"},
      {with("um_per_K", "um_per_k"), "(is \"um_per_k\" meant to be it?)"},
      {with("heat_W = 30.0", "heat_W = 30.0\ncolour = 3"), "heat.heater.colour: unknown key"},
      {with("kind = \"ambient\"", "kind = \"air\""), "net.toml:8: surrounding.room.kind: must be one of"},
      {with("{ room = 20.0 }", "{ hall = 20.0 }"), "there is no surrounding \"hall\"; there are: room"},
      {with("{ room = 20.0 }", "{}"), "operating.temperatures_degC.room: this key is required"},
      {with("[[heat]]", "[[node]]\nname = \"lost\"\ncapacity_J_per_K = 1.0\n[[heat]]"),
       "net.toml:29: node.lost.name: no conduction, contact or gap film connects this node"},
      {with("[[heat]]",
            "[[node]]\nname = \"c\"\ncapacity_J_per_K = 1.0\n[[node]]\nname = \"d\"\ncapacity_J_per_K = 1.0\n"
            "[[conduction]]\nbetween = [\"c\", \"d\"]\nconductance_W_per_K = 1.0\n[[heat]]"),
       "node.c.name: no path leads from here to the node \"a\""},
      {with("[[film]]\nname = \"to_room\"\nsurrounding = \"room\"\nnode = \"b\"\narea_mm2 = "
            "50000.0\ncoefficient_W_per_m2K = 20.0\n",
            ""),
       "film: at least one [[film]] or [[coolant_circuit]] must lead heat away"},
      {with("[[film]]",
            "[[contact]]\nname = \"c\"\nbetween = [\"a\", \"b\"]\narea_mm2 = 9.0\nconductance_W_per_m2K = 9.0\n"
            "joint_fit = { assembly_pressure_Pa = 1e6, pressure_per_inner_rise_Pa_per_K = 0.0, "
            "pressure_per_outer_rise_Pa_per_K = -1.0 }\n[[film]]"),
       "contact.c.joint_fit.pressure_per_outer_rise_Pa_per_K: must be"},
      {"name = \"x\"\n[[material]]\nname = \"steel\"\n",
       "net.toml: node: there is none: this is a spindle description"},
      {"name = \"x\"\n", "net.toml:1: node: this key is required"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string said = error_of(text);
    EXPECT_NE(said.find(expected), std::string::npos) << "'" << said << "', expected '" << expected << "'";
  }
}

TEST(ByHand, a_description_is_told_from_a_hand_written_network) {
  EXPECT_TRUE(is_by_hand(motor_spindle));
  EXPECT_FALSE(is_by_hand(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml"));
  EXPECT_FALSE(is_by_hand("/nowhere.toml"));
}

}  // namespace by_hand_test
}  // namespace spindle_twin::rom::tests

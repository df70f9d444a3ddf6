#include "rom/boundary_values/held_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::rom::tests {
namespace held_law_test {

LawDrive turning_drive() {
  LawDrive drive;
  drive.speed_rpm = 4000.0;
  drive.load = 0.6;
  drive.current_A = 11.0;
  drive.power_W = 900.0;
  drive.flow_kg_per_s = Eigen::Vector2d(0.01, -0.02);
  return drive;
}

const Eigen::VectorXd surroundings_K = Eigen::Vector2d(288.0, 299.0);

TEST(NominalState, surroundings_are_as_they_are_and_parts_at_what_the_law_says_of_them) {
  BoundLaw bound;
  bound.first = {3, -1, 310.0};
  bound.second = {-1, 0, 305.0};
  const LawState state = nominal_state(bound, turning_drive(), surroundings_K);
  EXPECT_EQ(state[LawInput::first_K], 310.0);
  EXPECT_EQ(state[LawInput::second_K], 288.0);
  bound.first = {-1, 1, 310.0};
  bound.second = {-1, -1, 305.0};
  const LawState other = nominal_state(bound, turning_drive(), surroundings_K);
  EXPECT_EQ(other[LawInput::first_K], 299.0);
  EXPECT_EQ(other[LawInput::second_K], 305.0);
}

TEST(NominalState, has_the_machines_signals_and_the_flow_of_its_circuit_or_none) {
  BoundLaw bound;
  bound.nominal_pressure_Pa = 3e6;
  bound.nominal_displacement_m = 2e-6;
  bound.displacement_sign = -1.0;
  for (const int circuit : {-1, 0, 1}) {
    bound.circuit = circuit;
    const LawState state = nominal_state(bound, turning_drive(), surroundings_K);
    EXPECT_EQ(state[LawInput::flow_kg_per_s], circuit < 0 ? 0.0 : circuit == 0 ? 0.01 : -0.02);
    EXPECT_EQ(state[LawInput::speed_rpm], 4000.0);
    EXPECT_EQ(state[LawInput::pressure_Pa], 3e6);
    EXPECT_EQ(state[LawInput::displacement_m], -2e-6);
    EXPECT_EQ(state.load, 0.6);
    EXPECT_EQ(state.current_A, 11.0);
    EXPECT_EQ(state.power_W, 900.0);
  }
}

HeatSource heat_of(const LawParameters& parameters) {
  BoundLaw bound;
  bound.law.parameters = parameters;
  return {"heat", 1.0, {}, bound};
}

TEST(MeasuredDrive, each_heat_follows_the_current_or_the_power_or_neither) {
  struct Case {
    HeatSource source;
    bool current, power;
  };
  for (const Case& of : {Case{heat_of(CopperLaw{}), true, false}, Case{heat_of(MotorEfficiencyLaw{}), false, true},
                         Case{heat_of(WindageLaw{}), false, false}, Case{HeatSource{}, false, false}}) {
    EXPECT_EQ(reads_electricity(of.source), of.current || of.power);
    Boundaries boundaries;
    boundaries.sources = {HeatSource{}, of.source};
    EXPECT_EQ(follows_current(boundaries), of.current);
    EXPECT_EQ(follows_power(boundaries), of.power);
    EXPECT_EQ(has_physics(boundaries), of.source.physics.has_value());
  }
  Boundaries conductance;
  conductance.conductances.resize(2);
  EXPECT_FALSE(has_physics(conductance));
  conductance.conductances[1].physics = BoundLaw{};
  EXPECT_TRUE(has_physics(conductance));
}

TEST(MeasuredHeats, are_taken_in_the_order_of_their_sources_and_by_their_law_until_one_is_read) {
  Boundaries boundaries;
  boundaries.reference_speed_rpm = 1000.0;
  boundaries.sources = {{"plain", 10.0, {}}, {"first", 20.0, {}}, {"second", 30.0, {}}};
  boundaries.sources[1].measured = boundaries.sources[2].measured = true;
  EXPECT_EQ(measured_heats(boundaries), (std::vector<std::size_t>{1, 2}));
  const Eigen::VectorXd unread_W = unread_heats_W(boundaries);
  ASSERT_EQ(unread_W.size(), 2);
  EXPECT_TRUE(std::isnan(unread_W[0]) && std::isnan(unread_W[1]));
  CorrectionFactors factors = no_correction(boundaries);
  factors.heat << 1.0, 2.0, 0.5;
  const auto heats_W = [&](const Eigen::VectorXd& read_W) {
    OperatingState state;
    state.heat_W = read_W;
    BoundaryValues values = make_boundary_values(boundaries);
    evaluate_boundaries(boundaries, state, factors, values);
    return values.heat_W;
  };
  EXPECT_EQ(heats_W(Eigen::VectorXd(0)), Eigen::Vector3d(10.0, 40.0, 15.0));
  EXPECT_EQ(heats_W(unread_W), Eigen::Vector3d(10.0, 40.0, 15.0));
  EXPECT_EQ(heats_W(Eigen::Vector2d(7.0, 8.0)), Eigen::Vector3d(10.0, 14.0, 4.0));
  EXPECT_EQ(heats_W(Eigen::Vector2d(unread_W[0], 8.0)), Eigen::Vector3d(10.0, 40.0, 4.0));
  EXPECT_EQ(heats_W(Eigen::VectorXd::Constant(1, 7.0)), Eigen::Vector3d(10.0, 14.0, 15.0)) << "too few";
  EXPECT_EQ(heats_W(Eigen::Vector2d(0.0, 8.0)), Eigen::Vector3d(10.0, 0.0, 4.0)) << "no heat is a heat";
}

}  // namespace held_law_test
}  // namespace spindle_twin::rom::tests

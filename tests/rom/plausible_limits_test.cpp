#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "rom/boundary_values/plausible_inputs.hpp"
#include "rom/units.hpp"

/// What is believed ends where plausible_inputs.hpp says: the end itself is believed, a hair beyond is not.
namespace spindle_twin::rom::tests {
namespace plausible_limits_test {

Boundaries cooled_spindle() {
  Boundaries boundaries;
  boundaries.reference_speed_rpm = 6000.0;
  boundaries.environments = {{"water", EnvironmentKind::coolant}, {"air", EnvironmentKind::ambient}};
  boundaries.circuits = {{"jacket", 0, 4180.0, {0}}};
  Conductance film;
  film.name = "jacket film";
  film.kind = ConductanceKind::environment_film;
  film.nominal_W_per_m2K = 500.0;
  film.area_m2 = 0.02;
  film.environment = 0;
  boundaries.conductances = {film};
  boundaries.sources = {{"motor", 90.0, {}}, {"bearing", 10.0, {}}};
  boundaries.operating.speed_rpm = 6000.0;
  boundaries.operating.load = 1.0;
  boundaries.operating.environment_K = Eigen::Vector2d(20.0 + zero_degC_K, 22.0 + zero_degC_K);
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, -0.1);
  return boundaries;
}

std::string fields(const std::vector<Implausible>& found) {
  std::string names;
  for (const Implausible& each : found) names += each.field + ";";
  return names;
}

constexpr double hair = 1e-9;

TEST(PlausibleLimits, speed_reaches_twice_the_fastest_that_is_said_of_the_spindle_either_way) {
  Boundaries boundaries = cooled_spindle();
  const auto most_rpm = [&](double certified_rpm) { return plausible_inputs(boundaries, certified_rpm).speed_rpm; };
  for (const auto& [operating_rpm, certified_rpm, fastest_rpm] :
       {std::tuple{6000.0, 0.0, 6000.0}, {-9000.0, 0.0, 9000.0}, {3000.0, 24000.0, 24000.0}, {100.0, 200.0, 6000.0}}) {
    boundaries.operating.speed_rpm = operating_rpm;
    EXPECT_EQ(most_rpm(certified_rpm).max, 2.0 * fastest_rpm);
    EXPECT_EQ(most_rpm(certified_rpm).min, -2.0 * fastest_rpm);
  }
}

TEST(PlausibleLimits, inputs_are_believed_up_to_their_ends) {
  const Boundaries boundaries = cooled_spindle();
  const auto said = [&](const auto& change) {
    OperatingState state = boundaries.operating;
    change(state);
    return fields(implausible_inputs(boundaries, plausible_inputs(boundaries), state));
  };
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(said([&](OperatingState& s) { s.load = sign * 3.0; }), "");
    EXPECT_EQ(said([&](OperatingState& s) { s.load = sign * (3.0 + hair); }), "load;");
    EXPECT_EQ(said([&](OperatingState& s) { s.speed_rpm = sign * 12000.0; }), "");
    EXPECT_EQ(said([&](OperatingState& s) { s.speed_rpm = sign * 12001.0; }), "speed_rpm;");
    EXPECT_EQ(said([&](OperatingState& s) { s.environment_K[0] += sign * (25.0 - hair); }), "");
    EXPECT_EQ(said([&](OperatingState& s) { s.environment_K[0] += sign * (25.0 + hair); }), "water_degC;");
    EXPECT_EQ(said([&](OperatingState& s) { s.environment_K[1] += sign * (30.0 - hair); }), "");
    EXPECT_EQ(said([&](OperatingState& s) { s.environment_K[1] += sign * (30.0 + hair); }), "air_degC;");
    EXPECT_EQ(said([&](OperatingState& s) { s.flow_kg_per_s[0] = sign * 0.5; }), "");
    EXPECT_EQ(said([&](OperatingState& s) { s.flow_kg_per_s[0] = sign * (0.5 + hair); }), "jacket_kg_per_s;");
  }
  EXPECT_EQ(said([](OperatingState& s) {
              s = {1e6, 70.0, Eigen::Vector2d(900.0, 100.0), Eigen::VectorXd::Constant(1, 60.0)};
            }),
            "speed_rpm;load;water_degC;air_degC;jacket_kg_per_s;");
}

TEST(PlausibleLimits, a_message_rounds_to_a_hundredth_and_speaks_in_degC) {
  const Boundaries boundaries = cooled_spindle();
  OperatingState state = boundaries.operating;
  state.environment_K[0] = 100.0 + zero_degC_K + 0.128;
  state.flow_kg_per_s[0] = 3.5;
  const std::vector<Implausible> found = implausible_inputs(boundaries, plausible_inputs(boundaries), state);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].message, "100.13 is not plausible; believed is -5 to 45 degC, not kelvin");
  EXPECT_EQ(found[1].message, "3.5 is not plausible; believed is -0.5 to 0.5 kg/s, not kg/min");
}

TEST(PlausibleLimits, films_contacts_and_none_at_all_each_by_their_kind) {
  Boundaries boundaries = cooled_spindle();
  boundaries.circuits.clear();
  boundaries.operating.flow_kg_per_s.resize(0);
  const auto said = [&](ConductanceKind kind, double nominal_W_per_m2K) {
    boundaries.conductances[0].kind = kind;
    boundaries.conductances[0].nominal_W_per_m2K = nominal_W_per_m2K;
    return fields(implausible_description(boundaries, 1e4));
  };
  for (const ConductanceKind film :
       {ConductanceKind::gap_film, ConductanceKind::air_film, ConductanceKind::environment_film}) {
    for (const double believed : {0.1, 5e4}) EXPECT_EQ(said(film, believed), "") << believed;
    for (const double wrong : {0.0999, 50001.0}) EXPECT_EQ(said(film, wrong), "film jacket film;") << wrong;
  }
  for (const double believed : {1.0, 1e6}) EXPECT_EQ(said(ConductanceKind::contact, believed), "") << believed;
  for (const double wrong : {0.999, 1000001.0}) {
    EXPECT_EQ(said(ConductanceKind::contact, wrong), "contact jacket film;") << wrong;
  }
  EXPECT_EQ(said(ConductanceKind::contact, 0.0), "") << "switched off on purpose";
}

TEST(PlausibleLimits, heats_warm_the_whole_spindle_by_a_kelvin_per_second_at_most) {
  Boundaries boundaries = cooled_spindle();
  EXPECT_EQ(fields(implausible_description(boundaries, 100.0)), "") << "100 W, 100 J/K";
  const std::vector<Implausible> found = implausible_description(boundaries, 80.0);
  ASSERT_EQ(fields(found), "source;");
  EXPECT_EQ(found[0].message,
            "100 W in all are not plausible; they would warm the whole spindle (80 J/K) by 1.25 K/s, believed is up to "
            "80 W");
  boundaries.plausible = {{"heat_W", between(0.5, 50.0)}};
  EXPECT_EQ(implausible_description(boundaries, 1000.0).at(0).message,
            "100 W in all are not plausible; they would warm the whole spindle (1000 J/K) by 0.1 K/s, believed is 0.5 "
            "to 50 W");
}

TEST(PlausibleLimits, results_live_between_minus_40_and_300_degC_and_of_both_the_hottest_is_told) {
  const Boundaries boundaries = cooled_spindle();
  const auto said = [&](double coldest_degC, double hottest_degC) {
    return fields(implausible_temperatures(boundaries, coldest_degC + zero_degC_K, hottest_degC + zero_degC_K));
  };
  EXPECT_EQ(said(-40.0 + hair, 300.0 - hair), "");
  EXPECT_EQ(said(-40.0 - 1e-6, 20.0), "coldest temperature;");
  EXPECT_EQ(said(20.0, 300.0 + 1e-6), "hottest temperature;");
  EXPECT_EQ(said(-50.0, 400.0), "hottest temperature;");
}

}  // namespace plausible_limits_test
}  // namespace spindle_twin::rom::tests

#include <gtest/gtest.h>

#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/read/input_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::rom {
namespace boundary_values_boundaries_test {

Boundaries make_boundaries() {
  Boundaries boundaries;
  boundaries.reference_speed_rpm = 6000.0;
  boundaries.environments = {{"coolant", EnvironmentKind::coolant}, {"ambient", EnvironmentKind::ambient}};
  boundaries.operating = {6000.0, 1.0, Eigen::Vector2d(300.15, 298.15)};
  Conductance contact;
  contact.name = "contact";
  contact.nominal_W_per_m2K = 5000.0;
  Conductance film;
  film.name = "film";
  film.nominal_W_per_m2K = 100.0;
  film.environment = 1;
  film.law = {0.2, {{0.8, 1.0}}, 0.0, false};
  boundaries.conductances = {contact, film};
  boundaries.sources = {{"bearing", 50.0, {0.0, {{1.0, 1.0}}, 0.0, true}}};
  return boundaries;
}

/// A schedule file that lives as long as the test's statement block.
class ScheduleFile {
 public:
  explicit ScheduleFile(const std::string& text) : path_(folder_.write("schedule.csv", text)) {}
  const std::string& path() const { return path_; }

 private:
  tests::TemporaryFolder folder_;
  std::string path_;
};

std::string refusal(const std::string& text) {
  const ScheduleFile file(text);
  try {
    read_schedule(file.path(), make_boundaries());
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind(file.path(), 0), 0u) << message;
    return message.substr(file.path().size());
  }
  return {};
}

TEST(EvaluateBoundaries, factor_times_nominal_times_law) {
  const Boundaries boundaries = make_boundaries();
  CorrectionFactors factors = no_correction(boundaries);
  BoundaryValues values = make_boundary_values(boundaries);
  evaluate_boundaries(boundaries, boundaries.operating, factors, values);
  EXPECT_EQ(values.conductance_W_per_m2K, Eigen::Vector2d(5000.0, 100.0));
  EXPECT_EQ(values.heat_W[0], 50.0);
  EXPECT_EQ(values.environment_K, boundaries.operating.environment_K);

  factors.heat[0] = 0.46;
  factors.conductance[0] = 2.0;
  OperatingState state = boundaries.operating;
  state.speed_rpm = 12000.0;
  evaluate_boundaries(boundaries, state, factors, values);
  EXPECT_NEAR(values.conductance_W_per_m2K[0], 10000.0, 1e-9);
  EXPECT_NEAR(values.conductance_W_per_m2K[1], 180.0, 1e-9);
  EXPECT_NEAR(values.heat_W[0], 46.0, 1e-12);
}

TEST(Schedule, coolant_flow_holds_until_the_next_row_and_may_run_backwards) {
  Boundaries boundaries = make_boundaries();
  boundaries.circuits = {{"jacket", 0, 4180.0, {1}}, {"seat", 0, 4180.0, {0}}};
  boundaries.operating.flow_kg_per_s = Eigen::Vector2d(0.05, 0.01);
  const ScheduleFile file("time_s,speed_rpm,load,jacket_kg_per_s\n0,0,0,0.02\n10,0,0,-0.04\n20,0,0,0\n30,0,0,0\n");
  const Schedule schedule = read_schedule(file.path(), boundaries);
  OperatingState state = boundaries.operating;
  state_at(schedule, 9.0, state);
  EXPECT_EQ(state.flow_kg_per_s[0], 0.02);
  EXPECT_EQ(state.flow_kg_per_s[1], 0.01) << "a circuit that is not in the file keeps the operating state's flow";
  state_at(schedule, 10.0, state);
  EXPECT_EQ(state.flow_kg_per_s[0], -0.04);
  state_at(schedule, 25.0, state);
  EXPECT_EQ(state.flow_kg_per_s[0], 0.0);
}

TEST(Schedule, speed_and_load_hold_and_environments_run_linearly) {
  const ScheduleFile file(
      "\xEF\xBB\xBFspeed_rpm, time_s ,load,coolant_degC\r\n6000,0,1,20\r\n\r\n12000,100,0.5,30\r\n0,200,0,30\r\n");
  const Schedule schedule = read_schedule(file.path(), make_boundaries());
  ASSERT_EQ(schedule.rows.size(), 3u);
  EXPECT_EQ(schedule.end_s, 200.0);
  OperatingState state = make_boundaries().operating;
  state_at(schedule, 75.0, state);
  EXPECT_EQ(state.speed_rpm, 6000.0);
  EXPECT_EQ(state.load, 1.0);
  EXPECT_NEAR(state.environment_K[0], 273.15 + 27.5, 1e-10);
  EXPECT_EQ(state.environment_K[1], 298.15) << "an environment that is not in the file keeps the operating state's";
  state_at(schedule, 100.0, state);
  EXPECT_EQ(state.speed_rpm, 12000.0);
  state_at(schedule, -5.0, state);
  EXPECT_EQ(state.speed_rpm, 6000.0);
  state_at(schedule, 1e9, state);
  EXPECT_EQ(state.speed_rpm, 0.0);
  EXPECT_NEAR(state.environment_K[0], 303.15, 1e-10);
}

TEST(Schedule, current_and_power_hold_until_the_next_row_where_a_heat_follows_them) {
  Boundaries boundaries = make_boundaries();
  const ScheduleFile current("time_s,speed_rpm,load,current_A\n0,0,0,7.5\n10,0,0,-3\n20,0,0,0\n");
  try {
    read_schedule(current.path(), boundaries);
    ADD_FAILURE() << "nothing follows the current";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(":1: current_A: unknown column"), std::string::npos) << error.what();
  }
  BoundLaw copper, motor;
  copper.law.parameters = CopperLaw{};
  motor.law.parameters = MotorEfficiencyLaw{};
  boundaries.sources.push_back({"winding", 1.0, {}, copper});
  OperatingState state = boundaries.operating;
  state_at(read_schedule(current.path(), boundaries), 9.0, state);
  EXPECT_EQ(state.current_A, 7.5);
  EXPECT_FALSE(state.power_W.has_value());
  state_at(read_schedule(current.path(), boundaries), 10.0, state);
  EXPECT_EQ(state.current_A, -3.0);
  boundaries.sources.back().physics = motor;
  const ScheduleFile power("time_s,speed_rpm,load,power_W\n0,0,0,-250\n20,0,0,0\n");
  state_at(read_schedule(power.path(), boundaries), 5.0, state);
  EXPECT_EQ(state.power_W, -250.0);
  EXPECT_FALSE(state.current_A.has_value());
}

TEST(Schedule, temperatures_alone_end_at_absolute_zero) {
  Boundaries boundaries = make_boundaries();
  boundaries.circuits = {{"jacket", 0, 4180.0, {1}}};
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.05);
  const ScheduleFile file(
      "time_s,speed_rpm,load,jacket_kg_per_s,coolant_degC\n0,-6000,-300,-500,-273.1\n10,-6000,-300,-500,-273.1\n");
  OperatingState state = boundaries.operating;
  state_at(read_schedule(file.path(), boundaries), 5.0, state);
  EXPECT_EQ(state.speed_rpm, -6000.0);
  EXPECT_EQ(state.load, -300.0);
  EXPECT_EQ(state.flow_kg_per_s[0], -500.0);
  EXPECT_NEAR(state.environment_K[0], 0.05, 1e-9);
  EXPECT_EQ(refusal("time_s,speed_rpm,load,coolant_degC\n0,1,1,-273.15\n1,1,1,20\n"),
            ":2: coolant_degC: is not above absolute zero, -273.15 degC");
}

TEST(Schedule, environments_run_linearly_between_any_two_rows_and_rows_know_their_line) {
  const ScheduleFile file("time_s,speed_rpm,load,coolant_degC\n0,1,1,20\n100,2,1,30\n\n140,3,1,10\n150,4,1,10\n");
  const Schedule schedule = read_schedule(file.path(), make_boundaries());
  OperatingState state = make_boundaries().operating;
  for (const auto& [time_s, degC] : {std::pair{0.0, 20.0},
                                     {50.0, 25.0},
                                     {100.0, 30.0},
                                     {110.0, 25.0},
                                     {130.0, 15.0},
                                     {140.0, 10.0},
                                     {145.0, 10.0}}) {
    state_at(schedule, time_s, state);
    EXPECT_NEAR(state.environment_K[0], 273.15 + degC, 1e-10) << time_s;
  }
  ASSERT_EQ(schedule.rows.size(), 4U);
  EXPECT_EQ(schedule.rows[1].line, 3);
  EXPECT_EQ(schedule.rows[2].line, 5);
  EXPECT_EQ(schedule.rows[2].time_s, 140.0);
}

TEST(Schedule, constant_schedule_holds_the_operating_state) {
  const Boundaries boundaries = make_boundaries();
  const Schedule schedule = constant_schedule(boundaries, 1800.0);
  EXPECT_EQ(schedule.rows.front().time_s, 0.0);
  EXPECT_EQ(schedule.rows.back().time_s, 1800.0);
  EXPECT_EQ(schedule.end_s, 1800.0);
  OperatingState state = boundaries.operating;
  state_at(schedule, 900.0, state);
  EXPECT_EQ(state.speed_rpm, 6000.0);
  EXPECT_EQ(state.environment_K, boundaries.operating.environment_K);
}

TEST(Schedule, bad_files_are_refused_with_line_and_column) {
  EXPECT_EQ(refusal("time_s,speed_rpm,load,flow\n0,1,1,1\n1,1,1,1\n"),
            ":1: flow: unknown column; allowed: time_s, speed_rpm, load, coolant_degC, ambient_degC");
  EXPECT_EQ(refusal("time_s,speed_rpm\n0,1\n1,1\n"),
            ":1: load: missing column; the header needs time_s, speed_rpm and load");
  EXPECT_EQ(refusal("time_s,speed_rpm,load,load\n0,1,1,1\n"), ":1: load: column given twice");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n1,nan,1\n"),
            ":3: speed_rpm: 'nan' is not a finite number with a decimal point");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1e999,1\n"),
            ":2: speed_rpm: '1e999' is not a finite number with a decimal point");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,6000rpm,1\n"),
            ":2: speed_rpm: '6000rpm' is not a finite number with a decimal point");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,,1\n"), ":2: speed_rpm: '' is not a finite number with a decimal point");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1\n"), ":2: 2 values, but the header names 3 columns");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n5,1,1\n6,1,1\n"), ":2: time_s: the first row must be at time 0");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n0,1,1\n"), ":3: time_s: times must rise from row to row");
  EXPECT_EQ(refusal("time_s,speed_rpm,load\n0,1,1\n"),
            ":2: a schedule needs at least two rows; the last one's time is the end");
  EXPECT_EQ(refusal("time_s,speed_rpm,load,coolant_degC\n0,1,1,-300\n"),
            ":2: coolant_degC: is not above absolute zero, -273.15 degC");
  EXPECT_EQ(refusal(""), ": empty; a header with the names of the columns is needed");
  EXPECT_THROW(read_schedule("/nonexistent.csv", make_boundaries()), InputError);
}

}  // namespace boundary_values_boundaries_test
}  // namespace spindle_twin::rom

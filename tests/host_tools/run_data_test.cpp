#include "host_tools/commands/offline/report/run_data.hpp"

#include <gtest/gtest.h>

#include <map>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/units.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::host_tools {
namespace run_data_test {

using Columns = std::map<std::string, std::vector<double>>;

rom::CsvTable table_of(const Columns& columns) {
  rom::CsvTable table;
  table.file = "table.csv";
  for (const auto& [name, values] : columns) {
    table.names.push_back(name);
    table.columns.push_back(values);
  }
  for (std::size_t row = 0; row < table.columns.front().size(); ++row) table.lines.push_back(static_cast<int>(row) + 2);
  return table;
}

/// Four rows of a daemon on the small network; every column its own numbers.
Columns history_columns() {
  return {{"time_s", {0, 10, 20, 30}},
          {"speed_rpm", {0, 3000, 6000, 6000}},
          {"load", {0, 1, 1, 1}},
          {"coolant_degC", {27, 27, 27, 25}},
          {"ambient_degC", {27, 27, 28, 29}},
          {"measured.sleeve_inner_degC", {27, 27.1, 27.3, 27.6}},
          {"measured.sleeve_middle_degC", {27, 27.0, 27.2, 27.4}},
          {"measured.sleeve_outer_degC", {27, 27.0, 27.1, 27.2}},
          {"predicted.sleeve_inner_degC", {27, 27.2, 27.4, 27.8}},
          {"predicted.sleeve_middle_degC", {27, 27.1, 27.3, 27.5}},
          {"predicted.sleeve_outer_degC", {27, 27.1, 27.2, 27.3}},
          {"predicted_sd.sleeve_inner_K", {0.5, 0.4, 0.3, 0.2}},
          {"part_maximum.rotor_degC", {27, 28, 30, 33}},
          {"part_maximum.bearing_degC", {27, 28, 29, 30}},
          {"part_maximum.sleeve_degC", {27, 27.2, 27.4, 27.8}},
          {"deformation.nose_um", {0, 0.5, 1.0, 2.0}},
          {"deformation_sd.nose_um", {0.1, 0.1, 0.2, 0.3}},
          {"heat_factor.bearing", {1, 0.9, 0.8, 0.7}},
          {"heat_factor.rotor", {1, 0.9, 0.8, 0.6}}};
}

/// The plant's log: other instants, a row every 5 s until 25 s.
Columns plant_columns() {
  const auto rising = [](double from, double per_s) {
    std::vector<double> values;
    for (int row = 0; row <= 5; ++row) values.push_back(from + 5.0 * row * per_s);
    return values;
  };
  return {{"time_s", rising(0, 1)},
          {"key_point.sleeve_inner_degC", rising(27, 0.02)},
          {"key_point.sleeve_middle_degC", rising(27, 0.01)},
          {"key_point.sleeve_outer_degC", rising(27, 0.005)},
          {"part_maximum.rotor_degC", rising(27, 0.2)},
          {"deformation.nose_um", rising(0, 0.04)}};
}

RunData run_of(const Columns& history, double until_s = 1e9) {
  return gather_run(tests::small_network(), table_of(history), table_of(plant_columns()), "rotor", until_s);
}

TEST(RunData, reaches_as_far_as_history_and_plant_both_do_or_until_told) {
  EXPECT_EQ(run_of(history_columns()).time_s, (std::vector<double>{0, 10, 20}));
  EXPECT_EQ(run_of(history_columns(), 12.0).time_s, (std::vector<double>{0, 10}));
  EXPECT_EQ(run_of(history_columns(), 20.0).time_s, (std::vector<double>{0, 10, 20})) << "the last row counts";
}

TEST(RunData, each_quantity_is_its_own_column_and_the_plant_stands_on_the_axis_of_the_history) {
  const RunData run = run_of(history_columns());
  ASSERT_EQ(run.key_points.size(), 3U);
  const Quantity& inner = run.key_points[0];
  EXPECT_EQ(inner.name, "sleeve_inner");
  EXPECT_DOUBLE_EQ(inner.zero, 27.0);
  EXPECT_EQ(inner.measured, (std::vector<double>{27, 27.1, 27.3}));
  EXPECT_EQ(inner.twin, (std::vector<double>{27, 27.2, 27.4}));
  EXPECT_EQ(inner.twin_sd, (std::vector<double>{0.5, 0.4, 0.3}));
  EXPECT_TRUE(run.key_points[1].twin_sd.empty()) << "the history has none";
  ASSERT_EQ(inner.plant.size(), 3U);
  EXPECT_DOUBLE_EQ(inner.plant[1], 27.2);
  EXPECT_DOUBLE_EQ(inner.plant[2], 27.4);
  EXPECT_EQ(run.hottest.name, "rotor");
  EXPECT_EQ(run.hottest.twin, (std::vector<double>{27, 28, 30}));
  EXPECT_DOUBLE_EQ(run.hottest.plant[2], 31.0);
  EXPECT_EQ(run.nose.twin, (std::vector<double>{0, 0.5, 1.0}));
  EXPECT_EQ(run.nose.twin_sd, (std::vector<double>{0.1, 0.1, 0.2}));
  EXPECT_DOUBLE_EQ(run.nose.plant[1], 0.4);
  EXPECT_EQ(run.speed_rpm, 6000.0);
  EXPECT_EQ(run.ambient_degC, 28.0) << "of the last row shown";
  EXPECT_EQ(run.coolant_degC, 27.0);
}

/// The same network by itself, with the signals of the history and all factors 1.
TEST(RunData, uncorrected_is_the_network_with_the_signals_of_the_history) {
  const rom::Network network = tests::small_network();
  const RunData run = run_of(history_columns());
  const auto stepper = rom::make_runtime_stepper(network);
  rom::BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  rom::OperatingState state = network.boundaries.operating;
  for (std::size_t row = 0; row < 3; ++row) {
    state.speed_rpm = history_columns()["speed_rpm"][row];
    state.load = history_columns()["load"][row];
    state.environment_K[1] = history_columns()["ambient_degC"][row] + rom::zero_degC_K;
    rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
    if (row > 0) {
      ASSERT_EQ(stepper->advance(10.0, values), rom::StepStatus::ok);
    }
    rom::evaluate_outputs(network, stepper->temperatures_K(), outputs);
    EXPECT_DOUBLE_EQ(run.key_points[0].uncorrected.at(row), outputs.key_points_K[0] - rom::zero_degC_K);
    EXPECT_DOUBLE_EQ(run.hottest.uncorrected.at(row), outputs.part_maximum_K[0] - rom::zero_degC_K);
    EXPECT_DOUBLE_EQ(run.nose.uncorrected.at(row), rom::um_per_m * outputs.deformations_m[0]);
  }
  EXPECT_GT(run.hottest.uncorrected[2], run.hottest.uncorrected[1]);
}

TEST(RunData, sources_that_share_their_factor_are_one_line) {
  Columns history = history_columns();
  EXPECT_EQ(run_of(history).factor_names, std::vector<std::string>{"all sources"})
      << "they differ only after the plant's end";
  EXPECT_EQ(run_of(history).heat_factors, (std::vector<std::vector<double>>{{1, 0.9, 0.8}}));
  history["heat_factor.rotor"][1] = 0.5;
  EXPECT_EQ(run_of(history).factor_names, (std::vector<std::string>{"bearing", "rotor"}));
  EXPECT_EQ(run_of(history).heat_factors, (std::vector<std::vector<double>>{{1, 0.9, 0.8}, {1, 0.5, 0.8}}));
}

TEST(RunData, an_unknown_part_and_a_history_after_the_plant_are_told) {
  try {
    gather_run(tests::small_network(), table_of(history_columns()), table_of(plant_columns()), "stator", 1e9);
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'stator' does not exist; allowed: rotor, bearing, sleeve"),
              std::string::npos)
        << error.what();
  }
  Columns late = history_columns();
  late["time_s"] = {100, 110, 120, 130};
  EXPECT_THROW(run_of(late), rom::InputError);
}

}  // namespace run_data_test
}  // namespace spindle_twin::host_tools

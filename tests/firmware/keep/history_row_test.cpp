#include "firmware/keep/history_row.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace keep_history_row_test {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line + ",");
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// Cells by the names of their columns.
std::map<std::string, std::string> by_column(const rom::Network& network, const Snapshot& snapshot) {
  const std::vector<std::string> names = cells_of(history_header(network)), cells = cells_of(history_row(snapshot));
  EXPECT_EQ(names.size(), cells.size());
  std::map<std::string, std::string> row;
  for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) {
    EXPECT_TRUE(row.emplace(names[i], cells[i]).second) << names[i] << " stands twice";
  }
  return row;
}

/// Rising numbers from `first`, so that no two entries of a snapshot are alike.
template <class Values>
void number_from(double first, Values& values) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = first + static_cast<double>(i);
}

void fill_predictions(Snapshot& snapshot) {
  number_from(zero_degC_K + 20.0, snapshot.measured_K);
  number_from(zero_degC_K + 30.0, snapshot.raw_K);
  number_from(0.25, snapshot.measured_age_s);
  number_from(zero_degC_K + 40.0, snapshot.predicted_K);
  number_from(zero_degC_K + 50.0, snapshot.uncorrected_K);
  number_from(zero_degC_K + 60.0, snapshot.part_maximum_K);
  number_from(0.5, snapshot.heat_factor);
  number_from(5.5, snapshot.conductance_factor);
  number_from(0.125, snapshot.predicted_deviation_K);
  number_from(0.375, snapshot.part_maximum_deviation_K);
  snapshot.deformation_m[0] = 11e-6;
  snapshot.deformation_raw_m[0] = 12e-6;
  snapshot.deformation_deviation_m[0] = 13e-6;
  snapshot.nose_m = 14e-6;
  snapshot.nose_uncorrected_m = 15e-6;
  snapshot.tare_m = 16e-6;
  snapshot.probe_m[0] = 17e-6;
  snapshot.probe_age_s[0] = 18.5;
}

void fill_rest(Snapshot& snapshot) {
  snapshot.signals[0] = 6000.0;
  snapshot.signals[1] = 0.5;
  snapshot.signals[2] = zero_degC_K + 22.0;
  snapshot.signals[3] = zero_degC_K + 23.0;
  snapshot.signals[static_cast<std::size_t>(Signal::current)] = 31.0;
  snapshot.signals[static_cast<std::size_t>(Signal::power)] = 3200.0;
  snapshot.sensor_update[1] = {zero_degC_K + 70.0, 0.5, 4.0, 0.75, -0.25, 0.125, 6, 0};
  snapshot.displacement_update = {21e-6, 22e-6, 9e-12, 0.625, 0.0, 0.0, 5, 0};
  snapshot.displacement = {0, 24e-6, 25e-6};
  snapshot.displacement_orders = 26;
  snapshot.sensor_health[1].misfit_ratio = 0.0625;
  snapshot.sensor_health[1].fault = SensorFault::drift;
  snapshot.sensor_orders = 27;
  snapshot.sequence = 28;
  snapshot.clock_ns = 29;
  snapshot.tare_count = 30;
  snapshot.correction_count = 31;
  snapshot.updates = 32;
  snapshot.parameters_determined = 33;
  snapshot.displacement_count = 34;
  snapshot.model_time_s = 35.5;
  snapshot.data_age_s = 36.5;
  snapshot.state = State::degraded;
  snapshot.quality = 37;
  snapshot.fault = 38;
  snapshot.overruns = 39;
  snapshot.correction_enabled = true;
  snapshot.correction_freeze = 40;
  snapshot.sensor_order = SensorOrder::acknowledge;
  snapshot.sensor_quality[1] = SensorQuality::stale;
  snapshot.sensor_health[1].state = SensorState::failed;
}

TEST(HistoryRow, each_column_holds_what_its_name_says_in_its_unit) {
  const rom::Network network = tests::small_network();
  Snapshot snapshot = first_snapshot(network);
  fill_predictions(snapshot);
  fill_rest(snapshot);
  const std::map<std::string, std::string> row = by_column(network, snapshot);
  const std::map<std::string, double> wanted{
      {"time_s", 35.5},
      {"sequence", 28},
      {"state", bits(State::degraded)},
      {"quality", 37},
      {"fault", 38},
      {"overruns", 39},
      {"correction_enabled", 1},
      {"correction_freeze", 40},
      {"sensor_order", bits(SensorOrder::acknowledge)},
      {"correction_count", 31},
      {"data_age_s", 36.5},
      {"speed_rpm", 6000},
      {"load", 0.5},
      {"coolant_degC", 22},
      {"ambient_degC", 23},
      {"nose_um", 14},
      {"nose_uncorrected_um", 15},
      {"tare_um", 16},
      {"measured.sleeve_inner_degC", 20},
      {"measured.sleeve_outer_degC", 22},
      {"raw.sleeve_outer_degC", 32},
      {"age.sleeve_outer_s", 2.25},
      {"predicted.sleeve_inner_degC", 40},
      {"uncorrected.sleeve_outer_degC", 52},
      {"part_maximum." + network.parts[1].name + "_degC", 61},
      {"deformation.nose_um", 11},
      {"deformation_raw.nose_um", 12},
      {"deformation_sd.nose_um", 13},
      {"heat_factor.bearing", 0.5},
      {"conductance_factor.rotor_bearing", 5.5},
      {"conductance_factor.air", 8.5},
      {"predicted_sd.sleeve_outer_K", 2.125},
      {"part_maximum_sd." + network.parts[1].name + "_K", 1.375},
      {"updates", 32},
      {"parameters_determined", 33},
      {"displacement_count", 34},
      {"displacement_um", 21},
      {"displacement_innovation_um", 22},
      {"displacement_innovation_sd_um", 3},
      {"displacement_test_ratio", 0.625},
      {"displacement_update", 5},
      {"clock_ns", 29},
      {"tare_count", 30},
      {"length_orders", 26},
      {"length_output", 0},
      {"length_m", 24e-6},
      {"length_sd_m", 25e-6},
      {"sensor_orders", 27},
      {"probe.nose_m", 17e-6},
      {"probe_age.nose_s", 18.5},
      {"current_A", 31},
      {"power_W", 3200},
  };
  for (const auto& [column, value] : wanted) {
    ASSERT_TRUE(row.contains(column)) << column;
    EXPECT_NEAR(std::stod(row.at(column)), value, 1e-8 * std::abs(value)) << column;
  }
  const std::string second = network.key_points[1].name;
  const std::map<std::string, double> update{{"observation." + second + "_degC", 70},
                                             {"innovation." + second + "_K", 0.5},
                                             {"innovation_sd." + second + "_K", 2},
                                             {"test_ratio." + second, 0.75},
                                             {"update." + second, 6},
                                             {"offset." + second + "_K", -0.25},
                                             {"offset_sd." + second + "_K", 0.125},
                                             {"sensor_misfit." + second, 0.0625},
                                             {"sensor_quality." + second, bits(SensorQuality::stale)},
                                             {"sensor_state." + second, bits(SensorState::failed)},
                                             {"sensor_fault." + second, bits(SensorFault::drift)}};
  for (const auto& [column, value] : update) {
    ASSERT_TRUE(row.contains(column)) << column;
    EXPECT_DOUBLE_EQ(std::stod(row.at(column)), value) << column;
  }
}

TEST(HistoryRow, a_value_that_does_not_exist_is_an_empty_cell) {
  const rom::Network network = tests::small_network();
  const std::map<std::string, std::string> row = by_column(network, first_snapshot(network));
  for (const char* column : {"measured.sleeve_inner_degC", "heat_factor.bearing", "probe.nose_m", "current_A",
                             "displacement_um", "test_ratio.sleeve_outer", "length_m"}) {
    EXPECT_EQ(row.at(column), "") << column;
  }
  for (const auto& [column, cell] : row) EXPECT_EQ(cell.find("nan"), std::string::npos) << column;
  EXPECT_EQ(row.at("correction_enabled"), "0");
}

/// A replay reads them back: every bit of what the cycle was given stays.
TEST(HistoryRow, what_the_cycle_was_given_comes_back_to_the_bit) {
  const rom::Network network = tests::small_network();
  Snapshot snapshot = first_snapshot(network);
  snapshot.signals[0] = 5999.9999999999991;
  snapshot.measured_K[0] = zero_degC_K + 1.0 / 3.0;
  snapshot.raw_K[0] = zero_degC_K - 2.0 / 3.0;
  snapshot.measured_age_s[0] = 0.1 + 0.2;
  snapshot.probe_m[0] = 1e-6 / 3.0;
  snapshot.displacement.value_m = 2e-6 / 3.0;
  const std::map<std::string, std::string> row = by_column(network, snapshot);
  EXPECT_EQ(std::stod(row.at("speed_rpm")), snapshot.signals[0]);
  EXPECT_EQ(std::stod(row.at("measured.sleeve_inner_degC")) + zero_degC_K, snapshot.measured_K[0]);
  EXPECT_EQ(std::stod(row.at("raw.sleeve_inner_degC")) + zero_degC_K, snapshot.raw_K[0]);
  EXPECT_EQ(std::stod(row.at("age.sleeve_inner_s")), snapshot.measured_age_s[0]);
  EXPECT_EQ(std::stod(row.at("probe.nose_m")), snapshot.probe_m[0]);
  EXPECT_EQ(std::stod(row.at("length_m")), snapshot.displacement.value_m);
}

}  // namespace keep_history_row_test
}  // namespace spindle_twin::firmware

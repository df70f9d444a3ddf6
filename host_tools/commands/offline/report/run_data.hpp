#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "rom/network.hpp"
#include "rom/read/csv_table.hpp"

namespace spindle_twin::host_tools {

/// One quantity as plant, twin and uncorrected model have it; all curves of a run share one time axis.
struct Quantity {
  std::string name;
  std::string unit;
  double zero = 0.0;             ///< what a rise counts from
  std::vector<double> measured;  ///< empty where there is no sensor
  std::vector<double> plant;
  std::vector<double> twin;
  std::vector<double> uncorrected;
  std::vector<double> twin_sd = {};  ///< what the twin says of its own error, 1σ; empty where the history has none
};

/// Highest temperature of a part as the twin published it, above the reference temperature.
struct PartRises {
  std::string name;
  std::vector<double> rises_K;
};

struct RunData {  // NOLINT(public-members): plain data, the columns of one run
  std::string spindle;
  double speed_rpm = 0.0;  ///< at the end
  double ambient_degC = 0.0;
  double coolant_degC = 0.0;
  std::vector<double> time_s;
  std::vector<Quantity> key_points;
  std::vector<std::array<double, 2>> key_point_places_m;  ///< r, z
  std::vector<PartRises> part_rises;
  nlohmann::ordered_json outlines = nlohmann::ordered_json::array();  ///< as outlines_json() gives them
  Quantity hottest;                                                   ///< maximum of the part asked for
  Quantity nose;
  std::vector<std::string> factor_names;  ///< one for all if the sources share a factor
  std::vector<std::vector<double>> heat_factors;
};

/// Puts the daemon's history and the plant's log on the history's time axis, as far as both reach and `until_s`, and
/// runs the network beside them with all factors 1 and the history's operating signals: that is the uncorrected model.
/// Throws rom::InputError for a missing column, and for a part that the network does not have.
RunData gather_run(const rom::Network& network, const rom::CsvTable& history, const rom::CsvTable& plant,
                   const std::string& part, double until_s);

}  // namespace spindle_twin::host_tools

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

enum class FmuQuantity {
  speed_rpm,
  load,
  environment_K,
  flow_kg_per_s,
  measured_heat_W,
  start_temperature_K,
  heat_factor,
  conductance_factor,
  key_point_K,
  part_mean_K,
  part_maximum_K,
  deformation_m,
  contact_pressure_Pa,
  heat_W,
  coolant_outlet_K,
  coolant_heat_W
};

enum class FmuRole { input, fixed_parameter, tunable_parameter, output };

/// A variable of the FMU; its value reference is its place in the list.
struct FmuVariable {
  std::string name;
  std::string description;
  std::string unit;  ///< a name of fmu_units(), empty for a bare number
  FmuRole role = FmuRole::output;
  FmuQuantity quantity = FmuQuantity::speed_rpm;
  Eigen::Index index = 0;  ///< among those of its quantity
  double start = 0.0;      ///< of inputs and parameters
};

/// All variables of a network's FMU; model description and binary derive the same list from the same file.
std::vector<FmuVariable> fmu_variables(const rom::Network& network);

/// What ties model description and binary to one network file: "{8-4-4-4-12}" hex digits of its SHA-256.
std::string fmu_guid(std::span<const std::uint8_t> rom_file);

}  // namespace spindle_twin::host_tools

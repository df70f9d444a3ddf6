#include "host_tools/virtual_spindle/plant_registers.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "rom/boundary_values/environments.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr std::uint16_t not_fitted = 0x8000;
constexpr std::size_t channels = 16;
constexpr std::size_t circuits = 4;

std::uint16_t as_int16(double value) {
  return static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(std::clamp(value, -32767.0, 32767.0))));
}

void put_float(PlantRegisters& registers, std::size_t address, double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  registers[address] = static_cast<std::uint16_t>(bits >> 16);
  registers[address + 1] = static_cast<std::uint16_t>(bits & 0xFFFF);
}

void put_floats(PlantRegisters& registers, std::size_t address, const std::vector<double>& values, std::size_t slots) {
  for (std::size_t i = 0; i < std::min(values.size(), slots); ++i) put_float(registers, address + 2 * i, values[i]);
}

double environment_degC(const rom::Boundaries& boundaries, const PlantSnapshot& snapshot, rom::EnvironmentKind kind) {
  return rom::first_environment_K(boundaries, kind, snapshot.operating).value_or(boundaries.reference_temperature_K) -
         rom::zero_degC_K;
}

}  // namespace

PlantRegisters encode_plant(const rom::Boundaries& boundaries, const PlantSnapshot& snapshot) {
  PlantRegisters registers{};
  const double speed_rpm = std::abs(snapshot.operating.speed_rpm);
  const double coolant_degC = environment_degC(boundaries, snapshot, rom::EnvironmentKind::coolant);
  const double ambient_degC = environment_degC(boundaries, snapshot, rom::EnvironmentKind::ambient);
  registers[0] = 0x1234;
  registers[1] = 1;
  registers[2] = static_cast<std::uint16_t>(snapshot.steps);
  registers[3] = static_cast<std::uint16_t>(snapshot.measured_degC.size());
  registers[4] = static_cast<std::uint16_t>(std::lround(std::min(speed_rpm, 65535.0)));
  registers[5] = as_int16(1000.0 * snapshot.operating.load);
  registers[6] = as_int16(100.0 * coolant_degC);
  registers[7] = as_int16(100.0 * ambient_degC);
  for (std::size_t c = 0; c < channels; ++c) {
    registers[8 + c] = c < snapshot.measured_degC.size() ? as_int16(100.0 * snapshot.measured_degC[c]) : not_fitted;
  }
  const Eigen::VectorXd& flow_kg_per_s = snapshot.operating.flow_kg_per_s;
  for (std::size_t c = 0; c < circuits; ++c) {
    const auto circuit = static_cast<Eigen::Index>(c);
    registers[24 + c] = circuit < flow_kg_per_s.size() ? as_int16(1e4 * flow_kg_per_s[circuit]) : not_fitted;
  }
  const auto measured = [](const std::optional<double>& value, double counts) {
    return value ? as_int16(counts * *value) : not_fitted;
  };
  registers[28] = measured(snapshot.operating.current_A, 100.0);
  registers[29] = measured(snapshot.operating.power_W, 0.1);
  put_float(registers, 30, snapshot.time_s);
  put_float(registers, 32, speed_rpm);
  put_float(registers, 34, snapshot.operating.load);
  put_float(registers, 36, coolant_degC);
  put_float(registers, 38, ambient_degC);
  put_floats(registers, 40, snapshot.measured_degC, channels);
  put_float(registers, 100, snapshot.time_s);
  put_floats(registers, 102, snapshot.deformation_um, 4);
  put_floats(registers, 110, snapshot.key_point_degC, channels);
  put_floats(registers, 142, snapshot.part_max_degC, 32);
  return registers;
}

}  // namespace spindle_twin::host_tools

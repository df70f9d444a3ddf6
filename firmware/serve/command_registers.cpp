#include "firmware/serve/command_registers.hpp"

#include <cmath>

#include "firmware/serve/pack.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

bool touches(WriteRange written, Register which, int slot = 0) {
  const RegisterEntry& entry = entry_of(which);
  const int first = entry.address + slot * words_of(entry.type);
  return written.address < first + words_of(entry.type) && first < written.address + written.count;
}

CorrectionOrder correction_order(double value) {
  if (std::isnan(value)) return CorrectionOrder::as_configured;
  return value == 0.0 ? CorrectionOrder::off : CorrectionOrder::on;
}

void take_tare(RegisterImage& image, PlcCommand& command) {
  const double order = get(image, Register::command_tare);
  if (order == 1.0 || order == 2.0) {
    command.tare_order = order == 1.0 ? TareOrder::take : TareOrder::clear;
    ++command.tare_orders;
  }
  put(image, Register::command_tare, 0.0);
}

void take_sensors(RegisterImage& image, PlcCommand& command) {
  const double order = get(image, Register::command_sensors);
  if (order == 1.0 || order == 2.0 || order == 3.0) {
    command.sensor_order = order == 1.0   ? SensorOrder::tare
                           : order == 2.0 ? SensorOrder::clear_tare
                                          : SensorOrder::acknowledge;
    ++command.sensor_orders;
  }
  put(image, Register::command_sensors, 0.0);
}

void take_displacement(RegisterImage& image, PlcCommand& command) {
  using rom::m_per_um;
  const double output = get(image, Register::command_displacement_output);
  if (get(image, Register::command_displacement_take) == 1.0) {
    command.displacement = {std::isnan(output) ? std::size_t{0} : static_cast<std::size_t>(output),
                            m_per_um * get(image, Register::command_displacement),
                            m_per_um * get(image, Register::command_displacement_sd)};
    ++command.displacements;
  }
  put(image, Register::command_displacement_take, 0.0);
}

}  // namespace

WriteRange writable_registers() { return {command_block().address, command_block().length}; }

void clear_commands(RegisterImage& image) {
  for (const Register which :
       {Register::command_speed, Register::command_load, Register::command_coolant, Register::command_ambient,
        Register::command_current, Register::command_power, Register::command_correction,
        Register::command_displacement, Register::command_displacement_sd, Register::command_displacement_output}) {
    put_not_present(image, which);
  }
  for (const Register which : {Register::command_flow, Register::command_heat}) {
    for (int slot = 0; slot < entry_of(which).slots; ++slot) put_not_present(image, which, slot);
  }
  put(image, Register::command_tare, 0.0);
  put(image, Register::command_displacement_take, 0.0);
  put(image, Register::command_sensors, 0.0);
}

void take_commands(WriteRange written, std::int64_t now_ns, RegisterImage& image, PlcCommand& command) {
  struct Way {
    Register from;
    Signal to;
    double scale;
    double shift;
  };
  constexpr std::array<Way, first_flow_signal> ways{{{Register::command_speed, Signal::speed, 1.0, 0.0},
                                                     {Register::command_load, Signal::load, 0.01, 0.0},
                                                     {Register::command_coolant, Signal::coolant, 1.0, zero_degC_K},
                                                     {Register::command_ambient, Signal::ambient, 1.0, zero_degC_K},
                                                     {Register::command_current, Signal::current, 1.0, 0.0},
                                                     {Register::command_power, Signal::power, 1e3, 0.0}}};
  for (const Way& way : ways) {
    if (!touches(written, way.from)) continue;
    command.signals[static_cast<std::size_t>(way.to)] = {get(image, way.from) * way.scale + way.shift, now_ns};
  }
  constexpr double kg_per_gram = 1e-3;
  for (int c = 0; c < entry_of(Register::command_flow).slots; ++c) {
    if (!touches(written, Register::command_flow, c)) continue;
    command.signals[first_flow_signal + static_cast<std::size_t>(c)] = {
        kg_per_gram * get(image, Register::command_flow, c), now_ns};
  }
  for (int h = 0; h < entry_of(Register::command_heat).slots; ++h) {
    if (!touches(written, Register::command_heat, h)) continue;
    command.signals[first_heat_signal + static_cast<std::size_t>(h)] = {get(image, Register::command_heat, h), now_ns};
  }
  if (touches(written, Register::command_correction)) {
    command.correction = correction_order(get(image, Register::command_correction));
  }
  if (touches(written, Register::command_tare)) take_tare(image, command);
  if (touches(written, Register::command_displacement_take)) take_displacement(image, command);
  if (touches(written, Register::command_sensors)) take_sensors(image, command);
}

}  // namespace spindle_twin::firmware

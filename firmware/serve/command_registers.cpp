#include "firmware/serve/command_registers.hpp"

#include <algorithm>
#include <array>
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

constexpr std::array<Register, most_orders> order_registers{
    Register::command_correction, Register::command_displacement_take, Register::command_sensors,
    Register::command_tare,       Register::command_acknowledge,       Register::command_compensation};

std::uint16_t word_of(const RegisterImage& image, Register which) { return image[entry_of(which).address]; }

Displacement length_of(const RegisterImage& image) {
  using rom::m_per_um;
  const double output = get(image, Register::command_displacement_output);
  return {std::isnan(output) ? std::size_t{0} : static_cast<std::size_t>(output),
          m_per_um * get(image, Register::command_displacement),
          m_per_um * get(image, Register::command_displacement_sd)};
}

}  // namespace

WriteRange writable_registers() { return {command_block().address, command_block().length}; }

void clear_commands(RegisterImage& image) {
  for (const Register which :
       {Register::command_speed, Register::command_load, Register::command_coolant, Register::command_ambient,
        Register::command_current, Register::command_power, Register::command_correction,
        Register::command_displacement, Register::command_displacement_sd, Register::command_displacement_output,
        Register::command_order_id, Register::command_compensation}) {
    put_not_present(image, which);
  }
  for (const Register which : {Register::command_flow, Register::command_heat}) {
    for (int slot = 0; slot < entry_of(which).slots; ++slot) put_not_present(image, which, slot);
  }
  for (const Register which : {Register::command_tare, Register::command_displacement_take, Register::command_sensors,
                               Register::command_acknowledge}) {
    put(image, which, 0.0);
  }
}

bool may_order(WriteRange written) {
  return std::any_of(order_registers.begin(), order_registers.end(),
                     [&](Register which) { return touches(written, which); });
}

std::vector<Order> take_orders(WriteRange written, const Switched& switched, RegisterImage& image) {
  const std::uint16_t id = word_of(image, Register::command_order_id);
  std::vector<Order> orders;
  const auto take = [&](OrderKind kind, Register which) {
    const std::uint16_t code = word_of(image, which);
    const bool is_switch = kind == OrderKind::correction || kind == OrderKind::compensation;
    const std::uint16_t no_order = !is_switch                        ? std::uint16_t{0}
                                   : kind == OrderKind::compensation ? switched.compensation
                                                                     : switched.correction;
    if (!touches(written, which) || code == no_order) return;
    orders.push_back({kind, id == not_present_code ? std::uint16_t{0} : id, code, {}});
    if (kind == OrderKind::length) orders.back().length = length_of(image);
    if (!is_switch) put(image, which, 0.0);
  };
  take(OrderKind::correction, Register::command_correction);
  take(OrderKind::length, Register::command_displacement_take);
  take(OrderKind::sensors, Register::command_sensors);
  take(OrderKind::tare, Register::command_tare);
  take(OrderKind::acknowledge, Register::command_acknowledge);
  take(OrderKind::compensation, Register::command_compensation);
  return orders;
}

SignalSet take_signals(WriteRange written, std::int64_t now_ns, const RegisterImage& image, PlcSignals& told) {
  SignalSet taken;
  struct SignalWay {
    Register from;
    Signal to;
    double scale;
    double shift;
  };
  constexpr std::array<SignalWay, first_flow_signal> ways{
      {{Register::command_speed, Signal::speed, 1.0, 0.0},
       {Register::command_load, Signal::load, 0.01, 0.0},
       {Register::command_coolant, Signal::coolant, 1.0, zero_degC_K},
       {Register::command_ambient, Signal::ambient, 1.0, zero_degC_K},
       {Register::command_current, Signal::current, 1.0, 0.0},
       {Register::command_power, Signal::power, 1e3, 0.0}}};
  const auto take = [&](Register from, int slot, std::size_t to, double scale, double shift) {
    if (!touches(written, from, slot)) return;
    told.values[to] = {get(image, from, slot) * scale + shift, now_ns};
    taken.set(to);
  };
  for (const SignalWay& way : ways) take(way.from, 0, static_cast<std::size_t>(way.to), way.scale, way.shift);
  constexpr double kg_per_gram = 1e-3;
  for (std::size_t c = 0; c < slots::circuits; ++c) {
    take(Register::command_flow, static_cast<int>(c), first_flow_signal + c, kg_per_gram, 0.0);
  }
  for (std::size_t h = 0; h < slots::heats; ++h) {
    take(Register::command_heat, static_cast<int>(h), first_heat_signal + h, 1.0, 0.0);
  }
  return taken;
}

}  // namespace spindle_twin::firmware
